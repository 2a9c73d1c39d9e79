//! Identifiers of content for everybody.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use sha2::{Digest, Sha256};
use std::fmt;
use std::str::FromStr;

/// What identifies content outside of the host that made it: the sha256 of its bytes, written as 64 hexadecimal digits.
///
/// For files that others check, for addresses under which browsers keep things, for evidence that is kept. It costs a second for a
/// gigabyte or two; what is only compared inside one host, and often, has a [`crate::ContentHash`]. An id of parts of which one is such a
/// hash is no stronger than that part.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContentId([u8; 32]);

/// The first half of a [`ContentId`], 32 hexadecimal digits: where an address has to be short.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShortContentId([u8; 16]);

/// A text that is no identifier of content.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("an identifier of content has {digits} hexadecimal digits in lower case")]
pub struct NoContentId {
    digits: usize,
}

impl ContentId {
    /// Of bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// Of several parts, each with its length, so that parts which are cut elsewhere have another identifier.
    pub fn of_parts<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut hash = Sha256::new();
        for part in parts {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
        Self(hash.finalize().into())
    }

    /// With this sha256.
    pub const fn from_sha256(sha256: [u8; 32]) -> Self {
        Self(sha256)
    }

    /// The sha256.
    pub const fn sha256(&self) -> &[u8; 32] {
        &self.0
    }

    /// Its first half.
    pub fn short(&self) -> ShortContentId {
        let [first, _] = bytemuck::cast::<_, [[u8; 16]; 2]>(self.0);
        ShortContentId(first)
    }
}

/// Bytes of which a text is the hexadecimal digits, two for each.
fn parsed<const N: usize>(text: &str) -> Result<[u8; N], NoContentId> {
    let wrong = NoContentId { digits: 2 * N };
    let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
    if text.len() != 2 * N || !text.bytes().all(is_digit) {
        return Err(wrong);
    }
    let mut bytes = [0; N];
    for (k, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(&text[2 * k..2 * k + 2], 16).map_err(|_| wrong)?;
    }
    Ok(bytes)
}

macro_rules! text_form {
    ($($id:ident)*) => {$(
        impl FromStr for $id {
            type Err = NoContentId;

            fn from_str(text: &str) -> Result<Self, NoContentId> {
                parsed(text).map(Self)
            }
        }

        impl fmt::Display for $id {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
            }
        }

        impl fmt::Debug for $id {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(self, f)
            }
        }

        impl Serialize for $id {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $id {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
            }
        }
    )*};
}
text_form!(ContentId ShortContentId);

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IntoDeserializer;
    use serde::de::value::{Error, StrDeserializer};

    const OF_NOTHING: &str = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

    #[test]
    fn an_identifier_is_written_and_read_as_its_digits() {
        let id = ContentId::of(b"");
        assert_eq!((id.to_string().as_str(), OF_NOTHING.parse()), (OF_NOTHING, Ok(id)));
        assert_eq!((id.short().to_string().as_str(), OF_NOTHING[..32].parse()), (&OF_NOTHING[..32], Ok(id.short())));
        assert_eq!(ContentId::from_sha256(*id.sha256()), id);
        let read: StrDeserializer<'_, Error> = OF_NOTHING.into_deserializer();
        assert_eq!(ContentId::deserialize(read).unwrap(), id);
    }

    #[test]
    fn other_texts_are_refused() {
        let upper = OF_NOTHING.to_uppercase();
        for text in ["", "../../etc/passwd", &OF_NOTHING[1..], &upper, &"é".repeat(32)] {
            let why = text.parse::<ContentId>().unwrap_err().to_string();
            assert_eq!(why, "an identifier of content has 64 hexadecimal digits in lower case", "{text}");
        }
        assert!(OF_NOTHING.parse::<ShortContentId>().is_err());
    }

    #[test]
    fn parts_that_are_cut_elsewhere_are_other_content() {
        let id = |parts: &[&'static [u8]]| ContentId::of_parts(parts.iter().copied());
        assert_ne!(id(&[b"ab", b"c"]), id(&[b"a", b"bc"]));
        assert_ne!(id(&[b"abc"]), ContentId::of(b"abc"), "with its length");
    }
}
