//! Errors of a store: addresses, objects that are missing or too large, refusals.

use crate::credentials::CredentialsError;

/// Why a store does not do what it is asked for.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// An address of no kind of store.
    #[error("{address:?} is no store: a folder, file:///.., s3://BUCKET/.., http://.. or https://..")]
    Address {
        /// As given.
        address: String,
    },
    /// An address with a user, a password or a query.
    #[error(
        "the address of the store on {host} has a user, a password or a query: name them in its credentials instead"
    )]
    Secret {
        /// Its host.
        host: String,
    },
    /// A folder that cannot be made or opened, or settings that do not fit.
    #[error("the store {address} cannot be opened")]
    Open {
        /// Its address.
        address: String,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// Credentials that cannot be used.
    #[error(transparent)]
    Credentials(#[from] CredentialsError),
    /// The system has no threads or descriptors to give.
    #[error("the store cannot be asked")]
    Thread {
        /// Why.
        source: std::io::Error,
    },
    /// There is no such object.
    #[error("the store {address} has no {path}")]
    Missing {
        /// Path inside the store.
        path: String,
        /// Address of the store.
        address: String,
    },
    /// It cannot be reached, or it refuses.
    #[error("the store {address} does not give or take {path}")]
    Store {
        /// Path inside the store.
        path: String,
        /// Address of the store.
        address: String,
        /// Why.
        source: object_store::Error,
    },
    /// An object of more bytes than it can have.
    #[error("{path} in the store has more than {max_bytes} bytes")]
    TooLarge {
        /// Path inside the store.
        path: String,
        /// Its limit.
        max_bytes: u64,
    },
    /// An object of fewer bytes than it should have.
    #[error("{path} in the store is shorter than the index says")]
    Short {
        /// Path inside the store.
        path: String,
    },
}

impl StoreError {
    /// True where the store answered and the object is not what it should be; false where it could not be asked.
    pub fn is_of_object(&self) -> bool {
        matches!(self, Self::Missing { .. } | Self::TooLarge { .. } | Self::Short { .. })
    }
}
