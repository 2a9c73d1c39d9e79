//! The command line.

use daemon::Failure;
use std::io::Write;
use std::net::SocketAddr;
use std::path::PathBuf;

/// The page that shows a site in browsers: `groundplan view` and `groundplan up` start it. It stops on SIGTERM.
#[derive(Debug, Clone, clap::Parser)]
#[command(name = "groundplan-web", version = bus::own_build(), group = clap::ArgGroup::new("what").required(true).args(["config", "out"]))]
pub(crate) struct Arguments {
    /// Show the running daemons of this site, see config/site.toml
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,

    /// Stop when standard input ends, so that the server ends with the process that started it
    #[arg(long)]
    pub(crate) with_stdin: bool,

    /// An output folder.
    #[command(flatten)]
    pub(crate) folder: Option<FolderArguments>,
}

/// How an output folder is shown.
#[derive(Debug, Clone, clap::Args)]
#[group(id = "folder", multiple = true)]
pub(crate) struct FolderArguments {
    /// Show the maps in this output folder of `groundplan convert`
    #[arg(long, value_name = "MAPS", conflicts_with = "config", required = false)]
    pub(crate) out: PathBuf,

    /// Write the page with all dates into this new folder instead, to be opened without a server
    #[arg(long, value_name = "FOLDER", requires = "out")]
    pub(crate) export: Option<PathBuf>,

    /// Tasks of the schedule, as `groundplan tasks --json` prints them; without it those that elements of the maps name
    #[arg(long, value_name = "TASKS.json", requires = "out")]
    pub(crate) tasks: Option<PathBuf>,

    /// Address and port of the page; port 0 takes a free one. Another address than one of this machine asks viewers for a token,
    /// which is printed when it is made
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8642")]
    pub(crate) listen: SocketAddr,

    /// Folder of the token's hash [default: ~/.config/groundplan]
    #[arg(long, value_name = "FOLDER", requires = "out")]
    pub(crate) token: Option<PathBuf>,

    /// Certificate of the page for https, a PEM file
    #[arg(long, value_name = "FILE", requires = "key")]
    pub(crate) certificate: Option<PathBuf>,

    /// Private key of the certificate, a PEM file
    #[arg(long, value_name = "FILE", requires = "certificate")]
    pub(crate) key: Option<PathBuf>,
}

impl FolderArguments {
    /// The folder of the token's hash.
    ///
    /// # Errors
    /// No home folder, and none was named.
    pub(crate) fn token_folder(&self) -> Result<PathBuf, Failure> {
        let home = || std::env::home_dir().map(|home| home.join(".config/groundplan"));
        self.token.clone().or_else(home).ok_or_else(|| "there is no home folder: name one with --token".into())
    }

    /// Prints where the page is, for people and for programs that start this one.
    ///
    /// # Errors
    /// Standard output is gone.
    pub(crate) fn print_address(&self, url: &str) -> Result<(), Failure> {
        let mut out = std::io::stdout();
        writeln!(out, "{url}")?;
        out.flush()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[test]
    fn either_a_folder_or_a_site_is_shown() {
        let parse = |arguments: &str| Arguments::try_parse_from(arguments.split(' '));
        let folder = parse("groundplan-web --out maps --listen 127.0.0.1:0").unwrap();
        assert!(folder.config.is_none() && folder.folder.unwrap().listen.port() == 0);
        let site = parse("groundplan-web --config site.toml --with-stdin").unwrap();
        assert!(site.folder.is_none() && site.with_stdin);
        for wrong in [
            "groundplan-web",
            "groundplan-web --config a --out b",
            "groundplan-web --out a --key k",
            "groundplan-web --export a",
        ] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
