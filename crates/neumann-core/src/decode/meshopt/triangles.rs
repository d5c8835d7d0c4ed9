//! Triangles: a byte for most of them, since they share edges with those just before.

use super::{Rest, broken, signed, write_index};
use crate::decode::DecodeError;

/// Bytes of the table at the end.
const N_TABLE: usize = 16;

/// The sixteen things pushed last.
#[derive(Debug, Default)]
struct Recent<T> {
    entries: [T; 16],
    n_pushed: usize,
}

/// What triangles before say about the next one.
#[derive(Debug)]
struct State<'a> {
    data: Rest<'a>,
    edges: Recent<(u32, u32)>,
    vertices: Recent<u32>,
    /// The lowest index not used yet.
    next: u32,
    /// The index written out last.
    last: u32,
}

/// Fills `elements` with indices, a multiple of three.
pub(super) fn decode(stream: &[u8], stride: usize, elements: &mut [u8]) -> Result<(), DecodeError> {
    let (mut data, _, table) = Rest::open(stream, &[0xe1], |_| N_TABLE)?;
    let is_odd = |byte: &u8| byte >> 4 == 15 || byte & 15 == 15;
    if table[N_TABLE - 2..] != [0, 0] || table.iter().any(is_odd) {
        return Err(broken("the table at its end is not one"));
    }
    let codes = data.take(elements.len() / (3 * stride))?;
    let mut state = State {
        data,
        edges: Recent::default(),
        vertices: Recent::default(),
        next: 0,
        last: 0,
    };
    for (triangle, &code) in elements.chunks_exact_mut(3 * stride).zip(codes) {
        let corners = if code < 0xf0 {
            state.beside_an_edge(code >> 4, code & 15)?
        } else {
            state.alone(code & 15, table)?
        };
        for (element, corner) in triangle.chunks_exact_mut(stride).zip(corners) {
            write_index(element, corner);
        }
    }
    state.data.end()
}

impl State<'_> {
    /// A triangle at one of the last edges; `code` says what its third corner is.
    fn beside_an_edge(&mut self, edge: u8, code: u8) -> Result<[u32; 3], DecodeError> {
        let (a, b) = self.edges.get(edge)?;
        let c = match code {
            0 => self.unused(),
            1..=12 => self.vertices.get(code)?,
            13 => self.follow(self.last.wrapping_sub(1)),
            14 => self.follow(self.last.wrapping_add(1)),
            _ => self.written_out()?,
        };
        self.edges.push((c, b));
        self.edges.push((a, c));
        if !(1..=12).contains(&code) {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// A triangle without a recent edge.
    fn alone(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], DecodeError> {
        let is_in_table = code < 14;
        let pair = if is_in_table {
            table[usize::from(code)]
        } else {
            self.data.byte()?
        };
        if !is_in_table && pair == 0 {
            self.next = 0;
        }
        let a = if code == 15 {
            self.written_out()?
        } else {
            self.unused()
        };
        let [(b, b_is_new), (c, c_is_new)] = [self.corner(pair >> 4)?, self.corner(pair & 15)?];
        for edge in [(b, a), (c, b), (a, c)] {
            self.edges.push(edge);
        }
        for (vertex, is_new) in [(a, true), (b, b_is_new), (c, c_is_new)] {
            if is_new {
                self.vertices.push(vertex);
            }
        }
        Ok([a, b, c])
    }

    /// The second or third corner, and whether it is not a recent one.
    fn corner(&mut self, code: u8) -> Result<(u32, bool), DecodeError> {
        match code {
            0 => Ok((self.unused(), true)),
            15 => Ok((self.written_out()?, true)),
            _ => Ok((self.vertices.get(code - 1)?, false)),
        }
    }

    fn unused(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn follow(&mut self, index: u32) -> u32 {
        self.last = index;
        index
    }

    fn written_out(&mut self) -> Result<u32, DecodeError> {
        let step = signed(self.data.varint()?);
        Ok(self.follow(self.last.wrapping_add(step)))
    }
}

impl<T: Copy> Recent<T> {
    fn push(&mut self, entry: T) {
        self.entries[self.n_pushed % 16] = entry;
        self.n_pushed += 1;
    }

    /// That which has been pushed `back` before the last one.
    fn get(&self, back: u8) -> Result<T, DecodeError> {
        let place = self.n_pushed.checked_sub(1 + usize::from(back));
        let place = place.ok_or_else(|| broken("a triangle refers to one before the first"))?;
        Ok(self.entries[place % 16])
    }
}
