//! Ed25519 keys: those that robots have in their configuration, those that servers sign with, and lists of the latter.

use crate::objects::SiteName;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ring::rand::SystemRandom;
use ring::signature::{ED25519, ED25519_PUBLIC_KEY_LEN, Ed25519KeyPair, KeyPair, UnparsedPublicKey};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// Begins a public key as text.
const PREFIX: &str = "ed25519:";

const PEM_BEGIN: &str = "-----BEGIN PRIVATE KEY-----";
const PEM_END: &str = "-----END PRIVATE KEY-----";

/// A public key, as text `ed25519:` and its 32 bytes in base64.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PublicKey([u8; ED25519_PUBLIC_KEY_LEN]);

/// A private key, which has no text but its PEM file.
pub struct SigningKey {
    pair: Ed25519KeyPair,
}

/// A key that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum KeyError {
    /// A text that is no public key.
    #[error("{0:?} is no public key: ed25519: and 44 characters of base64, as `groundplan key new` prints it")]
    NotPublic(String),
    /// Bytes that are no private key.
    #[error("this is no private key of Ed25519 in PEM (PKCS#8), as `groundplan key new` writes it")]
    NotPrivate,
    /// The system has no random numbers.
    #[error("the system gives no random numbers for a key")]
    NoRandom,
}

/// The keys that may sign indices of a site, signed itself by a root key. A list with a higher number replaces those before: a key that
/// is not in it is revoked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyList {
    /// The site.
    pub site: SiteName,
    /// Number of the list; it rises.
    pub number: u64,
    /// The keys.
    pub keys: Vec<PublicKey>,
}

impl PublicKey {
    /// True if the private key that belongs to it signed this text as `what`.
    pub(crate) fn has_signed(&self, what: &str, text: &str, signature: &Signature) -> bool {
        UnparsedPublicKey::new(&ED25519, &self.0).verify(&message(what, text), &signature.0).is_ok()
    }
}

impl FromStr for PublicKey {
    type Err = KeyError;

    fn from_str(text: &str) -> Result<Self, KeyError> {
        let refused = || KeyError::NotPublic(text.chars().take(80).collect());
        let bytes = text.strip_prefix(PREFIX).and_then(|key| STANDARD.decode(key).ok()).ok_or_else(refused)?;
        bytes.try_into().map(Self).map_err(|_| refused())
    }
}

impl fmt::Display for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{PREFIX}{}", STANDARD.encode(self.0))
    }
}

impl fmt::Debug for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Serialize for PublicKey {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for PublicKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

impl SigningKey {
    /// A new key, and the text of its PEM file.
    ///
    /// # Errors
    /// The system has no random numbers.
    pub fn generate() -> Result<(Self, String), KeyError> {
        let pkcs8 = Ed25519KeyPair::generate_pkcs8(&SystemRandom::new()).map_err(|_| KeyError::NoRandom)?;
        let pair = Ed25519KeyPair::from_pkcs8(pkcs8.as_ref()).map_err(|_| KeyError::NotPrivate)?;
        let base64 = STANDARD.encode(pkcs8.as_ref());
        // PEM has lines of 64 characters.
        let lines: Vec<&str> = (0..base64.len()).step_by(64).map(|at| &base64[at..base64.len().min(at + 64)]).collect();
        Ok((Self { pair }, format!("{PEM_BEGIN}\n{}\n{PEM_END}\n", lines.join("\n"))))
    }

    /// The key of a PEM file; those of `openssl genpkey -algorithm ed25519`, which lack the public half, can be used too.
    ///
    /// # Errors
    /// Another text.
    pub fn from_pem(pem: &str) -> Result<Self, KeyError> {
        let body = pem.trim().strip_prefix(PEM_BEGIN).and_then(|rest| rest.strip_suffix(PEM_END));
        let base64: String = body.ok_or(KeyError::NotPrivate)?.split_whitespace().collect();
        let pkcs8 = STANDARD.decode(base64).map_err(|_| KeyError::NotPrivate)?;
        let pair = Ed25519KeyPair::from_pkcs8_maybe_unchecked(&pkcs8).map_err(|_| KeyError::NotPrivate)?;
        Ok(Self { pair })
    }

    /// Its public half.
    pub fn public(&self) -> PublicKey {
        let bytes = self.pair.public_key().as_ref();
        PublicKey(bytes.try_into().expect("a public key of Ed25519 has 32 bytes"))
    }

    /// Signs a text as `what`.
    pub(crate) fn sign(&self, what: &str, text: &str) -> Signature {
        let signature = self.pair.sign(&message(what, text));
        Signature(signature.as_ref().try_into().expect("a signature of Ed25519 has 64 bytes"))
    }
}

impl fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SigningKey of {}", self.public())
    }
}

/// A signature, as text in base64.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Signature([u8; 64]);

impl fmt::Debug for Signature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&STANDARD.encode(self.0))
    }
}

impl Serialize for Signature {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&STANDARD.encode(self.0))
    }
}

impl<'de> Deserialize<'de> for Signature {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let bytes = STANDARD.decode(text).ok().and_then(|bytes| bytes.try_into().ok());
        bytes.map(Self).ok_or_else(|| serde::de::Error::custom("a signature has 64 bytes in base64"))
    }
}

/// What is signed: a word for its kind, so that no signature is one of another kind, and the text.
fn message(what: &str, text: &str) -> Vec<u8> {
    format!("groundplan {what}\n{text}").into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Made by `openssl genpkey -algorithm ed25519`, for this test alone.
    const OF_OPENSSL: &str = "MC4CAQAwBQYDK2VwBCIEID4jUZ6oDRc6ybe1WJ0wQIwS4mZHvSC+BvlT4BVulCow";

    #[test]
    fn a_key_survives_its_file_and_its_text() {
        let (key, pem) = SigningKey::generate().unwrap();
        let again = SigningKey::from_pem(&pem).unwrap();
        assert_eq!(again.public(), key.public());
        assert_eq!(key.public().to_string().parse(), Ok(key.public()));
        assert!(pem.lines().all(|line| line.len() <= 64), "{pem}");
        let of_openssl = SigningKey::from_pem(&format!("{PEM_BEGIN}\n{OF_OPENSSL}\n{PEM_END}\n")).unwrap();
        let signature = of_openssl.sign("index", "x");
        assert!(of_openssl.public().has_signed("index", "x", &signature));
    }

    #[test]
    fn a_signature_is_of_one_text_of_one_kind_by_one_key() {
        let [(key, _), (other, _)] = [(); 2].map(|()| SigningKey::generate().unwrap());
        let signature = key.sign("index", "a");
        assert!(key.public().has_signed("index", "a", &signature));
        assert!(!key.public().has_signed("keys", "a", &signature));
        assert!(!key.public().has_signed("index", "b", &signature));
        assert!(!other.public().has_signed("index", "a", &signature));
    }

    #[test]
    fn other_texts_are_no_keys() {
        for text in ["", "ed25519:", "ed25519:AAAA", "rsa:AAAA", &format!("ed25519:{}", "A".repeat(400))] {
            assert!(matches!(text.parse::<PublicKey>(), Err(KeyError::NotPublic(_))), "{text}");
        }
        for pem in ["", PEM_BEGIN, "-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----"] {
            assert_eq!(SigningKey::from_pem(pem).unwrap_err(), KeyError::NotPrivate, "{pem}");
        }
    }
}
