//! A tev that is none: takes apart what is sent to it, by the protocol alone.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeMap;
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

/// Listens for one connection, on a port of its own.
pub(crate) struct FakeTev {
    address: String,
    received: Arc<Mutex<Received>>,
    thread: JoinHandle<()>,
}

/// What has come so far.
#[derive(Clone, Default)]
pub(crate) struct Received {
    pub(crate) images: BTreeMap<String, Image>,
    pub(crate) n_created: usize,
    pub(crate) n_grabs: usize,
    pub(crate) largest_packet: usize,
}

/// An image as tev has it.
#[derive(Clone, Default)]
pub(crate) struct Image {
    pub(crate) size: (usize, usize),
    /// Names of the channels, in their order.
    pub(crate) order: Vec<String>,
    pub(crate) channels: BTreeMap<String, Vec<f32>>,
    pub(crate) n_updates: usize,
}

impl FakeTev {
    /// Takes whatever comes.
    pub(crate) fn listen() -> Self {
        Self::leaving_after(usize::MAX)
    }

    /// Goes away after so many packets.
    pub(crate) fn leaving_after(n_packets: usize) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let received = Arc::new(Mutex::new(Received::default()));
        let shared = Arc::clone(&received);
        let thread = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            for _ in 0..n_packets {
                let Some(packet) = packet(&mut stream) else {
                    break;
                };
                shared.lock().unwrap().take(packet);
            }
        });
        Self {
            address,
            received,
            thread,
        }
    }

    pub(crate) fn address(&self) -> &str {
        &self.address
    }

    /// What has come until now.
    #[allow(dead_code, reason = "not all tests look on")]
    pub(crate) fn so_far(&self) -> Received {
        self.received.lock().unwrap().clone()
    }

    /// All that has come, at the end of the connection.
    pub(crate) fn finish(self) -> Received {
        self.thread.join().unwrap();
        self.received.lock().unwrap().clone()
    }
}

/// The next packet without its length; `None` at the end.
fn packet(stream: &mut TcpStream) -> Option<Fields> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).ok()?;
    let length = u32::from_le_bytes(length) as usize;
    let mut bytes = vec![0; length - 4];
    stream.read_exact(&mut bytes).ok()?;
    Some(Fields { bytes, at: 0 })
}

/// The fields of a packet, one after the other.
struct Fields {
    bytes: Vec<u8>,
    at: usize,
}

impl Fields {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let field = self.bytes[self.at..self.at + N].try_into().unwrap();
        self.at += N;
        field
    }

    fn number(&mut self) -> usize {
        i32::from_le_bytes(self.take()).try_into().unwrap()
    }

    fn longs(&mut self, n: usize) -> Vec<usize> {
        let long = |_| i64::from_le_bytes(self.take()).try_into().unwrap();
        (0..n).map(long).collect()
    }

    fn text(&mut self) -> String {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|byte| *byte == 0).unwrap();
        let text = String::from_utf8(rest[..length].to_vec()).unwrap();
        self.at += length + 1;
        text
    }

    fn texts(&mut self, n: usize) -> Vec<String> {
        (0..n).map(|_| self.text()).collect()
    }
}

impl Received {
    fn take(&mut self, mut fields: Fields) {
        self.largest_packet = self.largest_packet.max(fields.bytes.len() + 4);
        let [kind, grabs_focus] = fields.take();
        self.n_grabs += usize::from(grabs_focus);
        let name = fields.text();
        match kind {
            4 => self.create(name, &mut fields),
            6 => self.images.get_mut(&name).unwrap().update(&mut fields),
            _ => panic!("a packet of type {kind}"),
        }
        assert_eq!(fields.at, fields.bytes.len(), "nothing stands behind it");
    }

    fn create(&mut self, name: String, fields: &mut Fields) {
        self.n_created += 1;
        let (width, height) = (fields.number(), fields.number());
        let n_channels = fields.number();
        let order = fields.texts(n_channels);
        let plane = vec![0.0; width * height];
        let channels = order.iter().map(|name| (name.clone(), plane.clone()));
        let image = Image {
            size: (width, height),
            channels: channels.collect(),
            order,
            n_updates: 0,
        };
        self.images.insert(name, image);
    }
}

impl Image {
    fn update(&mut self, fields: &mut Fields) {
        self.n_updates += 1;
        let n_channels = fields.number();
        let names = fields.texts(n_channels);
        let [x, y, width, height] = std::array::from_fn(|_| fields.number());
        assert!(x + width <= self.size.0 && y + height <= self.size.1);
        let (firsts, steps) = (fields.longs(n_channels), fields.longs(n_channels));
        let rest = &fields.bytes[fields.at..];
        let floats: Vec<f32> = rest
            .chunks_exact(4)
            .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
            .collect();
        let mut end = 0;
        for (name, (first, step)) in names.iter().zip(firsts.iter().zip(&steps)) {
            let plane = self.channels.get_mut(name).unwrap();
            for pixel in 0..width * height {
                let at = first + pixel * step;
                let (row, column) = (y + pixel / width, x + pixel % width);
                plane[row * self.size.0 + column] = floats[at];
                end = end.max(at + 1);
            }
        }
        assert_eq!(floats.len(), end, "as many floats as are asked for");
        fields.at = fields.bytes.len();
    }
}
