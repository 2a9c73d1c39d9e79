//! `groundplan topic`: what is on the bus.

mod description;
mod echo;
mod hz;
mod list;
mod samples;

use crate::args::SiteOfRobotArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use bus::TopicName;
use daemon::SiteConfig;
use diagnostics::nearest_names_hint;

/// Arguments of `topic`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Subcommands.
    #[command(subcommand)]
    command: TopicCommand,
}

/// Subcommands.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum TopicCommand {
    /// List the topics that have a sample
    List {
        /// Print one JSON document on standard output and nothing else there
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteOfRobotArgs,
    },
    /// Print the last sample of a topic as JSON: what it is, what it was made from
    Echo {
        /// site, schedule-state, grids, grid/00 ..
        topic: String,
        /// Go on with every sample that comes, one a line, until SIGTERM
        #[arg(long)]
        follow: bool,
        /// On one line
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteOfRobotArgs,
    },
    /// Measure how often samples of a topic come, how large they are, and how long they take
    Hz {
        /// site, schedule-state, grids, grid/00 ..
        topic: String,
        /// Measure for this time [default: until SIGTERM]
        #[arg(long = "for", value_name = "SECONDS")]
        seconds: Option<f64>,
        /// Print one JSON document on standard output and nothing else there
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteOfRobotArgs,
    },
}

impl Run for Args {
    /// Lists topics, shows samples of one, or measures how they come.
    ///
    /// # Errors
    /// No bus, no such topic, no sample.
    fn run(&self) -> Result<Outcome, Failure> {
        let text = match &self.command {
            TopicCommand::List { json, site } => list::list(site, *json),
            TopicCommand::Echo { topic, follow, json, site } => {
                let topic = topic_of(topic)?;
                let config = config_for(site, topic)?;
                if *follow { echo::follow(&config, topic) } else { echo::echo(&config, topic, *json) }
            }
            TopicCommand::Hz { topic, seconds, json, site } => {
                let topic = topic_of(topic)?;
                hz::hz(&config_for(site, topic)?, topic, *seconds, *json)
            }
        }?;
        Ok(text.into())
    }
}

/// The configuration for a client of a topic: where each robot has its own, it must be known which.
fn config_for(site: &SiteOfRobotArgs, topic: TopicName) -> Result<SiteConfig, Failure> {
    if topic.is_of_robot() { site.config() } else { site.config_of_any() }
}

fn topic_of(name: &str) -> Result<TopicName, Failure> {
    let topic = TopicName::all().find(|t| t.to_string() == name);
    topic.ok_or_else(|| {
        let names: Vec<String> = TopicName::all().map(|t| t.to_string()).collect();
        let nearest = nearest_names_hint(name, names.iter().map(String::as_str));
        Failure::usage(format!("there is no topic {name:?}: see topic list{nearest}"))
    })
}
