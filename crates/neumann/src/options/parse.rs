//! Values of single options.

use std::ops::RangeInclusive;

use glam::Vec3;
use neumann_core::render::lobe::LARGEST_ANGLE;
use neumann_picture::tev::DEFAULT_ADDRESS;

use super::Exposure;

/// Pixels along an edge.
const MAX_EDGE: usize = 65_535;
/// Pixels of a picture.
const MAX_PIXELS: usize = 1 << 30;

/// `WxH`.
pub(crate) fn size(text: &str) -> Result<(usize, usize), String> {
    let parse = || {
        let (width, height) = text.split_once(['x', 'X'])?;
        Some((width.parse::<usize>().ok()?, height.parse::<usize>().ok()?))
    };
    let is_possible = |(width, height): &(usize, usize)| {
        (1..=MAX_EDGE).contains(width)
            && (1..=MAX_EDGE).contains(height)
            && width * height <= MAX_PIXELS
    };
    parse()
        .filter(is_possible)
        .ok_or_else(|| format!("use WIDTHxHEIGHT such as 1280x720, each from 1 to {MAX_EDGE}"))
}

/// `X,Y,W,H`, a part of a picture.
pub(crate) fn region(text: &str) -> Result<[usize; 4], String> {
    let parts: Option<Vec<usize>> = text.split(',').map(|p| p.trim().parse().ok()).collect();
    let is_possible = |[x, y, w, h]: &[usize; 4]| {
        [*x, *y].iter().all(|v| *v < MAX_EDGE)
            && [*w, *h].iter().all(|v| (1..=MAX_EDGE).contains(v))
    };
    parts
        .and_then(|parts| <[usize; 4]>::try_from(parts).ok())
        .filter(is_possible)
        .ok_or_else(|| "use COLUMN,ROW,WIDTH,HEIGHT such as 400,200,320,200, in pixels".to_owned())
}

/// `X,Y`, column and row.
pub(crate) fn pixel(text: &str) -> Result<[u32; 2], String> {
    let parse = || {
        let (x, y) = text.split_once(',')?;
        Some([x.trim().parse().ok()?, y.trim().parse().ok()?])
    };
    parse().ok_or_else(|| "use COLUMN,ROW such as 12,40, each from 0 on".to_owned())
}

/// `HOST:PORT`.
pub(crate) fn address(text: &str) -> Result<String, String> {
    let port = text.rsplit_once(':').filter(|(host, _)| !host.is_empty());
    let is_one = port.is_some_and(|(_, port)| port.parse::<u16>().is_ok_and(|port| port > 0));
    is_one
        .then(|| text.to_owned())
        .ok_or_else(|| format!("use HOST:PORT such as {DEFAULT_ADDRESS}"))
}

/// A technique: vertices from the light, and from the camera.
pub(crate) fn technique(text: &str) -> Result<[u16; 2], String> {
    let parse = || {
        let (s, t) = text.split_once(',')?;
        Some([s.trim().parse().ok()?, t.trim().parse().ok()?])
    };
    parse()
        .ok_or_else(|| "use S,T such as 1,2: vertices from the light, from the camera".to_owned())
}

/// A whole number of a range.
pub(crate) fn whole(
    range: RangeInclusive<u32>,
) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    move |text: &str| {
        text.parse()
            .ok()
            .filter(|n| range.contains(n))
            .ok_or_else(|| {
                let (least, most) = (range.start(), range.end());
                format!("use a whole number from {least} to {most}")
            })
    }
}

/// A whole number of 64 bits.
pub(super) fn long_whole(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("use a whole number from 0 to {}", u64::MAX))
}

/// `X,Y,Z`.
pub(super) fn vector(text: &str) -> Result<Vec3, String> {
    let parts: Option<Vec<f32>> = text.split(',').map(|p| p.trim().parse().ok()).collect();
    match parts.as_deref() {
        Some(&[x, y, z]) if x.is_finite() && y.is_finite() && z.is_finite() => {
            Ok(Vec3::new(x, y, z))
        }
        _ => Err("use three numbers such as 0,1.5,-4".to_owned()),
    }
}

/// `NAME=VALUE`.
pub(super) fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("use NAME=VALUE; 'neumann list parameters' shows what there is".to_owned()),
    }
}

/// A number of bytes, plain or in units of 1024 (K, M, G, T).
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let power = match text[number.len()..].to_ascii_uppercase().as_str() {
        "" | "B" => Some(0),
        "K" | "KB" | "KIB" => Some(1),
        "M" | "MB" | "MIB" => Some(2),
        "G" | "GB" | "GIB" => Some(3),
        "T" | "TB" | "TIB" => Some(4),
        _ => None,
    };
    let number: Option<f64> = number.trim().parse().ok();
    number
        .zip(power)
        .map(|(number, power)| number * 1024f64.powi(power))
        .filter(|bytes| (1.0..9e18).contains(bytes))
        .map(|bytes| bytes as u64)
        .ok_or_else(|| "use a number of bytes such as 800M or 4G".to_owned())
}

/// A number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    number(text, "use a number above 0", |v| v > 0.0)
}

/// A probability that is neither 0 nor 1.
pub(crate) fn probability(text: &str) -> Result<f64, String> {
    number(text, "use a number between 0 and 1", |v| v > 0.0 && v < 1.0)
}

/// A number above zero, single precision.
pub(crate) fn positive_single(text: &str) -> Result<f32, String> {
    number(text, "use a number above 0", |v| v > 0.0)
}

/// Zero or more, double precision.
pub(super) fn not_negative_double(text: &str) -> Result<f64, String> {
    number(text, "use a number from 0 on", |v| v >= 0.0)
}

/// Zero or more.
pub(super) fn not_negative(text: &str) -> Result<f32, String> {
    number(text, "use a number from 0 on", |v| v >= 0.0)
}

/// Any finite number.
pub(super) fn finite(text: &str) -> Result<f32, String> {
    number(text, "use a number", |_| true)
}

/// Stops of exposure, or `auto`: beyond 100, single precision has no brightness left.
pub(super) fn exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    number(text, "use stops from -100 to 100, or auto", |v| {
        (-100.0..=100.0).contains(&v)
    })
    .map(Exposure::Stops)
}

/// Degrees between 0 and 180.
pub(super) fn angle_of_view(text: &str) -> Result<f32, String> {
    number(text, "use degrees between 0 and 180", |v| {
        v > 0.0 && v < 180.0
    })
}

/// Degrees from the normal to a viewer, who does not look along the surface.
pub(crate) fn viewing_angle(text: &str) -> Result<f32, String> {
    number(text, "use degrees from 0 to 89", |v| {
        (0.0..=LARGEST_ANGLE).contains(&v)
    })
}

fn number<T>(text: &str, remedy: &str, is_possible: impl Fn(T) -> bool) -> Result<T, String>
where
    T: std::str::FromStr + Copy + Into<f64>,
{
    text.parse::<T>()
        .ok()
        .filter(|v| (*v).into().is_finite() && is_possible(*v))
        .ok_or_else(|| remedy.to_owned())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::{
        Exposure, angle_of_view, assignment, bytes, exposure, finite, positive, size, vector,
    };

    #[test]
    fn values_read_as_written() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        assert_eq!(vector("0,-1.5, 2e1"), Ok(Vec3::new(0.0, -1.5, 20.0)));
        assert_eq!(assignment("a=b=c"), Ok(("a".to_owned(), "b=c".to_owned())));
        assert_eq!(positive("0.25"), Ok(0.25));
        assert_eq!(bytes("1000"), Ok(1000));
        assert_eq!((bytes("1.5k"), bytes("2 GiB")), (Ok(1536), Ok(2 << 30)));
        assert_eq!(exposure("-1.5"), Ok(Exposure::Stops(-1.5)));
        assert_eq!(exposure("auto"), Ok(Exposure::Auto));
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["640", "0x4", "65536x1", "60000x60000", "-1x4", "ax4"] {
            assert!(size(text).is_err(), "{text}");
        }
        for text in ["1,2", "1,2,3,4", "a,b,c", "nan,0,0", "inf,0,0"] {
            assert!(vector(text).is_err(), "{text}");
        }
        for text in ["", "G", "0", "-1M", "1X", "nan", "inf", "1e30"] {
            assert!(bytes(text).is_err(), "{text}");
        }
        assert!(positive("0").is_err() && positive("nan").is_err() && positive("inf").is_err());
        assert!(angle_of_view("180").is_err() && finite("inf").is_err());
        assert!(exposure("automatic").is_err() && exposure("nan").is_err());
        assert!(assignment("=3").is_err() && assignment("x").is_err());
    }
}
