//! Addresses of stores.

use crate::credentials::{Credentials, CredentialsError};
use crate::error::StoreError;
use base64::Engine;
use object_store::aws::AmazonS3Builder;
use object_store::client::{Certificate, ClientOptions};
use object_store::http::HttpBuilder;
use object_store::local::LocalFileSystem;
use object_store::path::Path as ObjectPath;
use object_store::{ObjectStore, RetryConfig};
use reqwest::header::{AUTHORIZATION, HeaderMap, HeaderValue};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use url::Url;

/// A server that does not take a connection for so long is away.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// One that sends nothing for so long is away, too.
const READ_TIMEOUT: Duration = Duration::from_secs(15);

/// The longest that one request takes.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(120);

/// A request is tried again for so long; who asks tries again later.
const RETRY_TIMEOUT: Duration = Duration::from_secs(10);

/// A store, and what goes before all paths.
type Location = (Arc<dyn ObjectStore>, ObjectPath);

/// The store at an address. A folder that is not there is made only `to_write`.
pub(crate) fn open(address: &str, credentials: &Credentials, to_write: bool) -> Result<Location, StoreError> {
    let open =
        |source: Box<dyn std::error::Error + Send + Sync>| StoreError::Open { address: address.to_owned(), source };
    let Ok(url) = Url::parse(address) else { return folder(Path::new(address), to_write).map_err(open) };
    // They would be in every message and log.
    if !url.username().is_empty() || url.password().is_some() || url.query().is_some() {
        return Err(StoreError::Secret { host: url.host_str().unwrap_or_default().to_owned() });
    }
    // The library of cryptography that all of this program has; a second call changes nothing.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let retry = RetryConfig { max_retries: 3, retry_timeout: RETRY_TIMEOUT, ..RetryConfig::default() };
    let options = client_options(url.scheme(), credentials)?;
    match url.scheme() {
        "file" => {
            let path = url.to_file_path().map_err(|()| StoreError::Address { address: address.to_owned() })?;
            folder(&path, to_write).map_err(open)
        }
        "s3" => {
            let bucket = url.host_str().unwrap_or_default();
            let mut builder = AmazonS3Builder::new().with_bucket_name(bucket);
            builder = builder.with_region(credentials.region.as_deref().unwrap_or("us-east-1"));
            if let Some(endpoint) = &credentials.endpoint {
                let is_plain = endpoint.starts_with("http://");
                builder = builder.with_endpoint(endpoint).with_allow_http(is_plain);
            }
            builder = match (&credentials.access_key, &credentials.secret_key) {
                (Some(key), Some(secret)) => builder.with_access_key_id(key).with_secret_access_key(secret),
                _ => builder.with_skip_signature(true),
            };
            let is_plain = credentials.endpoint.as_ref().is_some_and(|endpoint| endpoint.starts_with("http://"));
            let builder = builder.with_client_options(options.with_allow_http(is_plain)).with_retry(retry);
            let store = builder.build().map_err(|why| open(why.into()))?;
            let prefix = ObjectPath::from_url_path(url.path()).map_err(|why| open(why.into()))?;
            Ok((Arc::new(store), prefix))
        }
        "http" | "https" => {
            let builder = HttpBuilder::new().with_url(url.as_str()).with_client_options(options).with_retry(retry);
            let store = builder.build().map_err(|why| open(why.into()))?;
            Ok((Arc::new(store), ObjectPath::default()))
        }
        _ => Err(StoreError::Address { address: address.to_owned() }),
    }
}

fn folder(path: &Path, to_write: bool) -> Result<Location, Box<dyn std::error::Error + Send + Sync>> {
    if to_write {
        std::fs::create_dir_all(path)?;
    }
    let store = LocalFileSystem::new_with_prefix(path)?.with_fsync(true);
    Ok((Arc::new(store), ObjectPath::default()))
}

/// Times, certificates and the user of requests.
fn client_options(scheme: &str, credentials: &Credentials) -> Result<ClientOptions, StoreError> {
    let mut options = ClientOptions::new()
        .with_connect_timeout(CONNECT_TIMEOUT)
        .with_read_timeout(READ_TIMEOUT)
        .with_timeout(REQUEST_TIMEOUT)
        .with_allow_http(scheme == "http");
    if let Some(path) = &credentials.authority {
        let bad = || CredentialsError::Authority { path: path.clone() };
        let pem = std::fs::read(path).map_err(|source| CredentialsError::Io { path: path.clone(), source })?;
        let certificates = Certificate::from_pem_bundle(&pem).map_err(|_| bad())?;
        if certificates.is_empty() {
            return Err(bad().into());
        }
        for certificate in certificates {
            options = options.with_root_certificate(certificate);
        }
    }
    if let (Some(user), Some(password)) = (&credentials.user, &credentials.password) {
        let text = base64::engine::general_purpose::STANDARD.encode(format!("{user}:{password}"));
        let mut value = HeaderValue::from_str(&format!("Basic {text}")).expect("base64 is a value of a header");
        value.set_sensitive(true);
        options = options.with_default_headers(HeaderMap::from_iter([(AUTHORIZATION, value)]));
    }
    Ok(options)
}
