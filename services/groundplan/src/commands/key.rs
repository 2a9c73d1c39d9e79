//! `groundplan key`: keys of a site for many machines, and the list of those that may sign.

use crate::failure::Failure;
use crate::run::{Outcome, Run};
use replica::{KeyList, PublicKey, SigningKey, SiteName};
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

/// Arguments of `key`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

/// What is done with keys.
#[derive(Debug, Clone, clap::Subcommand)]
enum Command {
    /// Write a new private key, and print its public half
    New {
        /// File of the key, PEM; it must not be there
        #[arg(value_name = "FILE.pem")]
        file: PathBuf,
    },
    /// Print the public half of a private key
    Show {
        /// File of the key
        #[arg(value_name = "FILE.pem")]
        file: PathBuf,
    },
    /// Write a list of the keys that may sign indices of a site, signed by its root key. A key that is not in a list of a higher
    /// number is revoked
    List {
        /// Name of the site
        #[arg(long)]
        site: SiteName,
        /// Number of the list, higher than those before
        #[arg(long)]
        number: u64,
        /// Private root key, PEM; it is needed for this alone, and need not be where the server runs
        #[arg(long, value_name = "ROOT.pem")]
        root: PathBuf,
        /// Public key that may sign; may be repeated
        #[arg(long = "key", value_name = "ed25519:..", required = true)]
        keys: Vec<PublicKey>,
        /// The list; an earlier one is replaced
        #[arg(short, long, value_name = "KEYS.jsonl")]
        out: PathBuf,
    },
}

const AFTER_HELP: &str = "\
Example:
  groundplan key new root.pem                  # stays with those who own the site
  groundplan key new signing.pem               # goes to the server
  groundplan key list --site tower --number 1 --root root.pem --key \"$(groundplan key show signing.pem)\" -o keys.jsonl

Robots name the public half of root.pem. To replace a signing key, write a list of a higher number with the new key alone and
restart the server with both: a robot that has seen the list takes nothing that the old key signs.";

impl Run for Args {
    /// Makes a key, shows one, or signs a list.
    ///
    /// # Errors
    /// Files that cannot be read or written, texts that are no keys.
    fn run(&self) -> Result<Outcome, Failure> {
        match &self.command {
            Command::New { file } => {
                let (key, pem) = SigningKey::generate().map_err(Failure::work)?;
                let failed = |why| Failure::work(format!("{} cannot be written: {why}", file.display()));
                // Nobody else reads it, from the first byte on; a key that is there is never replaced.
                let opened = OpenOptions::new().write(true).create_new(true).mode(0o600).open(file);
                let mut opened = opened.map_err(failed)?;
                opened.write_all(pem.as_bytes()).and_then(|()| opened.sync_all()).map_err(failed)?;
                Ok(Outcome::from(format!("{}\n", key.public())))
            }
            Command::Show { file } => Ok(Outcome::from(format!("{}\n", read_key(file)?.public()))),
            Command::List { site, number, root, keys, out } => {
                if let Ok(before) = fs::read_to_string(out) {
                    let named = |why| Failure::usage(format!("{}: {why}", out.display()));
                    let (before, _) = KeyList::parse_signed(&before).map_err(|why| named(why.to_string()))?;
                    if before.site == *site && before.number >= *number {
                        return Err(named(format!(
                            "it is list {}: the next one needs a higher --number",
                            before.number
                        )));
                    }
                }
                let list = KeyList { site: site.clone(), number: *number, keys: keys.clone() };
                let signed = list.signed_by(&read_key(root)?);
                let failed = |why| Failure::work(format!("{} cannot be written: {why}", out.display()));
                daemon::write_durably(out, signed.as_bytes()).map_err(failed)?;
                Ok(Outcome::silent())
            }
        }
    }
}

fn read_key(path: &Path) -> Result<SigningKey, Failure> {
    let named = |why: String| Failure::usage(format!("{}: {why}", path.display()));
    let pem = fs::read_to_string(path).map_err(|why| named(why.to_string()))?;
    SigningKey::from_pem(&pem).map_err(|why| named(why.to_string()))
}
