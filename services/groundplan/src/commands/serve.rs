//! `groundplan serve`: draws a site, and gives it to a store for robots on other machines.

use super::up::run_site;
use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};

/// Arguments of `serve`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

const AFTER_HELP: &str = "\
The site's configuration says where to, under which name, and with which keys:
  [serve]
  store = \"/srv/maps\"            # a folder behind any web server, or s3://BUCKET/..
  site = \"tower\"
  key = \"signing.pem\"            # groundplan key new signing.pem
  keys = \"keys.jsonl\"            # groundplan key list ..
  export = [\"maps\", \"vda5050\"]   # files as `export` writes them, for who has no groundplan:
                                 # maps, ground, world, usd, cloud, octomap, vda5050, lif,
                                 # open-rmf; none if left out

It runs what `up` runs, and site-server. Each [[robots]] of the site is a make of robot whose maps
are drawn once, for all robots of the site that follow them.";

impl Run for Args {
    /// Runs the daemons of a site and its server until it is stopped.
    ///
    /// # Errors
    /// As `up`; a configuration without [serve].
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.own_config()?;
        if config.serve.is_none() {
            let file = config.file.display();
            return Err(Failure::usage(format!("{file} has no [serve]: it names the store, the site and its keys")));
        }
        run_site(config, false)
    }
}
