//! `groundplan follow`: shows on this robot what the server of its site has drawn.

use super::up::run_site;
use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};

/// Arguments of `follow`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// The robot's configuration.
    #[command(flatten)]
    site: SiteArgs,
}

const AFTER_HELP: &str = "\
The robot's configuration says which store, which site, and by which key it is known:
  state = \"/var/lib/groundplan\"
  [follow]
  store = \"https://maps.site.example/maps\"
  site = \"tower\"
  roots = [\"ed25519:..\"]         # as groundplan key new printed it for the root key
  robot = \"husky\"                # whose maps, where the server has several makes
  storeys = [\"Level 2\", \"3\"]     # all if left out
  files = \"/var/lib/groundplan/files\"    # current in it: the exported files of what is shown

Nothing is drawn here: topics, ROS 2, the page and files are as where the site is drawn. Without
the store the robot shows what it has, goes on to the sets that were fetched ahead by its own clock,
and says until when they are valid.";

impl Run for Args {
    /// Runs the daemons of a robot that follows a server until it is stopped.
    ///
    /// # Errors
    /// As `up`; a configuration without [follow].
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.own_config()?;
        if config.follow.is_none() {
            let file = config.file.display();
            return Err(Failure::usage(format!(
                "{file} has no [follow]: it names the store, the site and its root keys"
            )));
        }
        run_site(config, false)
    }
}
