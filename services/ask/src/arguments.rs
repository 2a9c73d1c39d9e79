//! The command line.

use bus::RobotName;
use std::path::PathBuf;

/// Answers questions about a running site over HTTP and MCP: `groundplan ask` and `groundplan up` start it. It stops on SIGTERM.
#[derive(Debug, Clone, clap::Parser)]
#[command(name = "groundplan-ask", version = bus::own_build())]
pub(crate) struct Arguments {
    /// Configuration of the site, see config/site.toml
    #[arg(long, value_name = "FILE")]
    pub(crate) config: PathBuf,

    /// The robot whose maps are asked about, of a site with several
    #[arg(long, value_name = "NAME")]
    pub(crate) robot_name: Option<RobotName>,

    /// Stop when standard input ends, so that the server ends with the process that started it
    #[arg(long, conflicts_with = "stdio")]
    pub(crate) with_stdin: bool,

    /// Answer one client of MCP over standard input and output instead, in the place of the daemon
    #[arg(long)]
    pub(crate) stdio: bool,
}
