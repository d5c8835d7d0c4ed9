//! Pictures on their way to tev, the viewer of radiance, by its network protocol.
//!
//! A packet is its length (`u32`, these four bytes counted), a byte for its type, and fields
//! without padding, all little endian: truths are bytes, texts end with a zero byte, numbers are
//! `i32` unless said otherwise, lists have no length of their own.
//!
//! - Type 4 creates an image: whether it comes to the front, name, width, height, number of
//!   channels, their names.
//! - Type 6 updates a part of it: whether it comes to the front, name, number of channels, their
//!   names, x, y, width, height, the first float of each channel and the step from one to the
//!   next (`i64`), floats.
//!
//! Source: <https://github.com/Tom94/tev>, `include/tev/Ipc.h` and `src/Ipc.cpp`, in 2025.

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use neumann_core::film::Film;
use neumann_core::radiometry::Rgb;

use crate::PictureError;
use crate::exr_file::{channel_name, layer_names, layer_of};

/// Where tev listens unless it is told otherwise.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:14158";

const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;
/// Bytes of a packet, at most, unless a single row takes more.
const PACKET: usize = 2 << 20;
/// Who neither answers nor reads for so long has gone.
const PATIENCE: Duration = Duration::from_secs(5);

/// A tev that listens.
#[derive(Debug)]
pub struct Tev {
    stream: TcpStream,
    address: String,
    created: Option<Created>,
}

/// The image that was created last.
#[derive(Debug, PartialEq, Eq)]
struct Created {
    name: String,
    size: (usize, usize),
    n_layers: usize,
}

impl Tev {
    /// Finds the tev that listens at an address such as [`DEFAULT_ADDRESS`].
    ///
    /// # Errors
    /// If none does.
    pub fn connect(address: &str) -> Result<Self, PictureError> {
        let address = address.to_owned();
        match connect(&address) {
            Ok(stream) => Ok(Self {
                stream,
                address,
                created: None,
            }),
            Err(cause) => Err(PictureError::NoTev { address, cause }),
        }
    }

    /// Shows L and its layers as they are now in the image of this name, which is created first if
    /// the last one was another. Channels are called as in an .exr.
    ///
    /// # Errors
    /// If tev has gone.
    pub fn show(&mut self, name: &str, film: &Film) -> Result<(), PictureError> {
        let shown = self.send(name, film);
        shown.map_err(|cause| PictureError::TevGone {
            address: self.address.clone(),
            cause,
        })
    }

    fn send(&mut self, name: &str, film: &Film) -> io::Result<()> {
        let (width, height) = (film.width(), film.height());
        let wanted = Created {
            name: name.to_owned(),
            size: (width, height),
            n_layers: film.n_layers(),
        };
        if self.created.as_ref() != Some(&wanted) {
            let names: Vec<_> = layer_names(film.n_layers()).collect();
            let mut packet = Packet::new(CREATE_IMAGE, self.created.is_none());
            packet.text(name);
            packet.numbers(&[width, height, 3 * names.len()]);
            packet.channels(&names);
            packet.send(&mut self.stream)?;
            self.created = Some(wanted);
        }
        let n_rows = (PACKET / (size_of::<Rgb>() * width)).max(1);
        for (i, layer) in layer_names(film.n_layers()).enumerate() {
            let pixels = layer_of(film, i);
            for (part, rows) in pixels.chunks(n_rows * width).enumerate() {
                let mut packet = Packet::new(UPDATE_IMAGE, false);
                packet.text(name);
                packet.numbers(&[3]);
                packet.channels(std::slice::from_ref(&layer));
                packet.numbers(&[0, part * n_rows, width, rows.len() / width]);
                packet.longs(&[0, 1, 2]);
                packet.longs(&[3, 3, 3]);
                packet.pixels(rows);
                packet.send(&mut self.stream)?;
            }
        }
        Ok(())
    }
}

/// What a film is called in tev: the name of its scene, and the id of its method.
#[must_use]
pub fn image_name(scene: &str, method: &str) -> String {
    format!("{scene}, {method}")
}

/// The first place of this name where somebody listens.
fn connect(address: &str) -> io::Result<TcpStream> {
    let mut refusal = io::Error::new(io::ErrorKind::NotFound, "no such host");
    for place in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&place, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE))?;
                return Ok(stream);
            }
            Err(error) => refusal = error,
        }
    }
    Err(refusal)
}

/// A packet under construction.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8, grabs_focus: bool) -> Self {
        Self(vec![0, 0, 0, 0, kind, u8::from(grabs_focus)])
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
    }

    /// The names of red, green and blue of some layers.
    fn channels(&mut self, layers: &[String]) {
        for layer in layers {
            for channel in ["R", "G", "B"] {
                self.text(&channel_name(layer, channel));
            }
        }
    }

    /// Numbers of 32 bits; edges of films have fewer.
    fn numbers(&mut self, numbers: &[usize]) {
        for number in numbers {
            self.0.extend((*number as i32).to_le_bytes());
        }
    }

    fn longs(&mut self, longs: &[i64]) {
        self.0.extend(longs.iter().flat_map(|n| n.to_le_bytes()));
    }

    fn pixels(&mut self, pixels: &[Rgb]) {
        let floats = pixels.iter().flat_map(|pixel| pixel.to_array());
        self.0.extend(floats.flat_map(f32::to_le_bytes));
    }

    fn send(mut self, stream: &mut TcpStream) -> io::Result<()> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        stream.write_all(&self.0)
    }
}

#[cfg(test)]
#[path = "../../../tests/support/tev.rs"]
mod fake;

#[cfg(test)]
mod tests {
    use neumann_core::film::Film;
    use neumann_core::radiometry::Rgb;

    use super::fake::FakeTev;
    use super::{PACKET, Tev};

    /// A film of which every value is another.
    fn film(width: usize, height: usize, n_layers: usize) -> Film {
        let n = width * height;
        let plane = |k: usize| -> Vec<Rgb> {
            let value = |i: usize| (k * n + i) as f32;
            (0..n)
                .map(|i| Rgb::new(value(i), value(i) + 0.25, value(i) + 0.5))
                .collect()
        };
        let layers = (0..=n_layers).map(plane).collect();
        let total = plane(n_layers + 1);
        let variance = vec![Rgb::BLACK; n];
        Film::from_parts((width, height), 1, layers, total, &variance, 0).unwrap()
    }

    #[test]
    fn every_float_arrives_in_packets_that_are_not_large() {
        let fake = FakeTev::listen();
        let mut tev = Tev::connect(fake.address()).unwrap();
        // Three packets a layer, the last one of fewer rows.
        let film = film(1000, 401, 1);
        tev.show("a name", &film).unwrap();
        drop(tev);
        let received = fake.finish();
        assert!(received.largest_packet <= PACKET + 1024);
        let image = &received.images["a name"];
        assert_eq!(image.size, (1000, 401));
        assert_eq!(image.n_updates, 3 * 3);
        let names = ["R", "T0.R", "tail.R"];
        for (name, layer) in names
            .iter()
            .zip([film.total(), film.layer(0), film.layer(1)])
        {
            for (channel, at) in ["R", "G", "B"].iter().zip(0..) {
                let wanted: Vec<f32> = layer.iter().map(|p| p.to_array()[at]).collect();
                let name = name.replace('R', channel);
                assert_eq!(image.channels[&name], wanted, "{name}");
            }
        }
        assert_eq!(image.order[..4], ["R", "G", "B", "T0.R"]);
    }

    #[test]
    fn an_image_is_created_anew_only_if_it_is_another() {
        let fake = FakeTev::listen();
        let mut tev = Tev::connect(fake.address()).unwrap();
        for (name, film) in [
            ("a", film(4, 3, 2)),
            ("a", film(4, 3, 2)),
            ("a", film(2, 3, 2)),
            ("a", film(2, 3, 1)),
            ("b\0c", film(2, 3, 1)),
        ] {
            tev.show(name, &film).unwrap();
        }
        drop(tev);
        let received = fake.finish();
        assert_eq!(received.n_created, 4);
        assert_eq!(
            received.n_grabs, 1,
            "the first one alone comes to the front"
        );
        assert_eq!(received.images["a"].channels.len(), 9);
        assert!(received.images.contains_key("bc"));
    }

    #[test]
    fn who_does_not_listen_or_has_gone_is_named() {
        let fake = FakeTev::leaving_after(0);
        let address = fake.address().to_owned();
        let mut tev = Tev::connect(&address).unwrap();
        fake.finish();
        let film = film(64, 64, 2);
        let mut shown = (0..100).map(|_| tev.show("a", &film));
        let error = shown.find_map(Result::err).unwrap().to_string();
        assert!(
            error.starts_with(&format!("{address}: tev takes no more")),
            "{error}"
        );
        let error = Tev::connect(&address).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("{address}: no tev can")),
            "{error}"
        );
        assert!(error.contains("start tev"), "{error}");
    }
}
