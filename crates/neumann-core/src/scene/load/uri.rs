//! Data URIs, base64 and percent encoding: exporters break lines within base64, leave out its
//! padding or percent-encode it, and all that is accepted.

use data_url::forgiving_base64::decode_to_vec;
use percent_encoding::percent_decode;

/// What a URI of a buffer or an image turns out to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Uri {
    /// The bytes themselves.
    Data(Vec<u8>),
    /// A path relative to the scene file, percent-decoded.
    Relative(String),
    /// Anything with a scheme (`http:`, `file:`, also a drive letter).
    Foreign,
    /// A data URI that cannot be decoded.
    Broken,
}

impl Uri {
    /// Reads a URI as it stands in the file.
    pub(super) fn parse(uri: &str) -> Self {
        let Some(scheme) = scheme(uri) else {
            return match String::from_utf8(percent_decoded(uri.as_bytes())) {
                Ok(path) => Self::Relative(path),
                Err(_) => Self::Broken,
            };
        };
        if !scheme.eq_ignore_ascii_case("data") {
            return Self::Foreign;
        }
        let Some((head, payload)) = uri[scheme.len() + 1..].split_once(',') else {
            return Self::Broken;
        };
        let payload = percent_decoded(payload.as_bytes());
        if head.to_ascii_lowercase().ends_with(";base64") {
            base64_decoded(&payload).map_or(Self::Broken, Self::Data)
        } else {
            Self::Data(payload)
        }
    }
}

/// RFC 3986, 3.1: a letter, then letters, digits, `+`, `-`, `.`, up to the colon.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut bytes = scheme.bytes();
    (bytes.next()?.is_ascii_alphabetic()
        && bytes.all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b)))
    .then_some(scheme)
}

/// Replaces `%20` and the like; a stray percent sign stays as it is.
fn percent_decoded(text: &[u8]) -> Vec<u8> {
    percent_decode(text).collect()
}

/// RFC 4648, both alphabets; white space is skipped and padding optional.
fn base64_decoded(text: &[u8]) -> Option<Vec<u8>> {
    let standard = |byte: &u8| match byte {
        b'-' => b'+',
        b'_' => b'/',
        other => *other,
    };
    let text: Vec<u8> = text.iter().map(standard).collect();
    decode_to_vec(&text).ok()
}

#[cfg(test)]
mod tests {
    use super::Uri;

    #[test]
    fn data_uris_are_decoded_with_tolerance() {
        for uri in [
            "data:application/octet-stream;base64,Zm9vYg==",
            "data:;base64,Zm9vYg",
            "DATA:application/gltf-buffer;BASE64,Zm9v\r\n Yg==",
            "data:;base64,Zm9vYg%3D%3D",
            "data:,foob",
            "data:text/plain,f%6fob",
        ] {
            assert_eq!(Uri::parse(uri), Uri::Data(b"foob".to_vec()), "{uri}");
        }
        for uri in [
            "data:;base64",
            "data:;base64,Z",
            "data:;base64,Zm=9",
            "data:;base64,Zm9*",
        ] {
            assert_eq!(Uri::parse(uri), Uri::Broken, "{uri}");
        }
    }

    #[test]
    fn paths_are_percent_decoded_and_schemes_seen() {
        let relative = |path: &str| Uri::Relative(path.to_owned());
        assert_eq!(Uri::parse("Normal%20Map.png"), relative("Normal Map.png"));
        assert_eq!(Uri::parse("100%.png"), relative("100%.png"));
        assert_eq!(Uri::parse("%2e%2e/x"), relative("../x"));
        assert_eq!(Uri::parse("./a:b"), relative("./a:b"));
        for foreign in ["http://a/b", "file:///etc/passwd", "C:\\x.bin"] {
            assert_eq!(Uri::parse(foreign), Uri::Foreign, "{foreign}");
        }
    }
}
