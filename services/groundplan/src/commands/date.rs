//! `groundplan date`: the plan time of the running daemons.

use crate::args::SiteArgs;
use crate::date_argument;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::{ask, join, require_up, wait_for_schedule_state};
use daemon::{ScheduleRequest, SiteConfig, StatusBoard, schedule_report};

/// Arguments of `date`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Plan time: 2024-04-15 (its midnight), 2024-04-15T08:30:00, or with an offset, see site_zone in the schedule rules
    #[arg(value_name = "DATE")]
    date: Option<String>,

    /// The next instant at which anything changes
    #[arg(long, conflicts_with = "date")]
    next: bool,

    /// Follow the clock of this machine, in the site_zone of the schedule rules
    #[arg(long, conflicts_with_all = ["date", "next"])]
    wall: bool,

    /// Run at a rate: 3600 is an hour a second; from DATE, or from where the plan time is
    #[arg(long, value_name = "RATE", conflicts_with_all = ["next", "wall"])]
    simulate: Option<f64>,

    /// Return when the plan time is on disk; grids follow
    #[arg(long)]
    no_wait: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Sets the plan time, goes on to the next change, lets it move, or prints it.
    ///
    /// # Errors
    /// No daemons, an invalid date, no later change in the schedule; no maps of a date that is in force.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.config()?;
        if config.follow.is_some() {
            if self.date.is_some() || self.simulate.is_some() || self.next || self.wall {
                self.site.config_of_drawing()?;
            }
            return shown_by_follower(&config);
        }
        let instant_s = |text| date_argument::instant_at_site_s(text, &config);
        let date_s = self.date.as_deref().map(instant_s).transpose()?;
        let (bus, mut waiter) = join(&config)?;
        let request = match (date_s, self.simulate) {
            (from_s, Some(rate)) => ScheduleRequest::Simulate { rate, from_s },
            (Some(at_s), None) => ScheduleRequest::SetPlanTime { at_s },
            (None, None) if self.next => {
                let after_s = ask(&bus, &mut waiter, &ScheduleRequest::GetPlanTime)?.plan_time_s;
                ScheduleRequest::NextChange { after_s }
            }
            (None, None) if self.wall => ScheduleRequest::FollowWallClock,
            (None, None) => ScheduleRequest::GetPlanTime,
        };
        let answer = ask(&bus, &mut waiter, &request)?;
        // Without a site there is nothing to wait for: the plan time is kept for when there is one.
        if !self.no_wait && answer.state.epoch > 0 && request != ScheduleRequest::GetPlanTime {
            let effect = format!("the plan time {}", answer.plan_time_s.map(date_argument::text).unwrap_or_default());
            wait_for_schedule_state(&mut waiter, &config, &answer.state, &effect)?;
        }
        let time = answer.plan_time_s.map(date_argument::text);
        let text = match (&request, time) {
            (ScheduleRequest::SetPlanTime { .. } | ScheduleRequest::NextChange { .. }, Some(time)) => time + "\n",
            (_, time) => {
                let words = [time, Some(answer.clock)].into_iter().flatten().collect::<Vec<_>>();
                words.join("  ") + "\n"
            }
        };
        Ok(text.into())
    }
}

/// The plan time that a robot shows which follows the server of its site.
fn shown_by_follower(config: &SiteConfig) -> Result<Outcome, Failure> {
    require_up(config)?;
    let board = StatusBoard::of_site(config).map_err(Failure::work)?;
    let facts =
        schedule_report(&board).ok_or_else(|| Failure::work("site-follow has not begun: see groundplan status"))?.facts;
    let time = facts.plan_time_s.map(date_argument::text);
    Ok(([time, Some(facts.clock)].into_iter().flatten().collect::<Vec<_>>().join("  ") + "\n").into())
}
