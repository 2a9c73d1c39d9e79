//! `groundplan log`: what happened to a site, when, and who asked for it.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use bus::{ReportKind, names_of_users, relayed_report};
use daemon::{HistoryEntry, HistoryKind, SiteHistory, parse_history};
use diagnostics::counted;
use std::collections::BTreeMap;

/// Arguments of `log`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Only events of this kind; may be repeated
    #[arg(long, value_name = "KIND", value_enum)]
    kind: Vec<HistoryKind>,

    /// Only the newest
    #[arg(long, value_name = "N")]
    last: Option<usize>,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Lists the history of a site, from old to new; the site need not be up for its own user. Others get the newest of it.
    ///
    /// # Errors
    /// A history that cannot be read.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.config()?;
        let domain = config.domain().map_err(Failure::usage)?;
        let (mut entries, n_damaged) = match relayed_report(&domain, ReportKind::History).map_err(Failure::work)? {
            Some(lines) => parse_history(&lines),
            None => SiteHistory::of(&config).read().map_err(Failure::work)?,
        };
        entries.retain(|entry| self.kind.is_empty() || self.kind.contains(&entry.kind));
        let n_left_out = self.last.map_or(0, |last| entries.len().saturating_sub(last));
        entries.drain(..n_left_out);
        if n_damaged > 0 {
            eprintln!("groundplan: {} of the history cannot be read", counted(n_damaged, "line"));
        }
        if self.json {
            return Ok(Outcome::from(serde_json::to_string(&entries).map_err(Failure::work)? + "\n"));
        }
        let names = names_of_users();
        Ok(Outcome::from(entries.iter().map(|entry| line(entry, &names)).collect::<String>()))
    }
}

fn line(entry: &HistoryEntry, names: &BTreeMap<u32, String>) -> String {
    let by = entry.by.map_or_else(
        || "itself".to_owned(),
        |caller| names.get(&caller.uid).cloned().unwrap_or_else(|| caller.to_string()),
    );
    // To the second: `2026-11-22T22:10:00Z`.
    let at = entry.at.strftime("%Y-%m-%dT%H:%M:%SZ");
    let robot = entry.robot.as_ref().map_or_else(String::new, |robot| format!("{robot}: "));
    format!("{at}  {:<10} {by:<12} {robot}{}\n", entry.kind.to_string(), entry.summary)
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::Caller;

    #[test]
    fn a_line_names_the_user_and_the_moment() {
        let entry = HistoryEntry {
            at: "2026-11-22T22:10:00.123Z".parse().unwrap(),
            kind: HistoryKind::Date,
            by: Some(Caller { uid: 7 }),
            summary: "plan time 2024-03-01T00:00:00".to_owned(),
            robot: None,
        };
        let names = BTreeMap::from([(7, "alice".to_owned())]);
        assert_eq!(
            line(&entry, &names),
            "2026-11-22T22:10:00Z  date       alice        plan time 2024-03-01T00:00:00\n"
        );
        let by_itself = line(&HistoryEntry { by: None, ..entry.clone() }, &names);
        assert!(by_itself.contains("  date       itself  "), "{by_itself}");
        assert!(line(&entry, &BTreeMap::new()).contains("user 7"));
        let of_robot = HistoryEntry { robot: Some("lift".to_owned()), ..entry };
        assert!(line(&of_robot, &names).contains("alice        lift: plan time"));
    }
}
