//! The service by which goals of an action are cancelled.

use super::ros_service;
use crate::msg::builtin_interfaces::Time;
use serde::{Deserialize, Serialize};

/// A goal of an action.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GoalInfo {
    /// Its UUID.
    pub goal_id: [u8; 16],
    /// When it was accepted.
    pub stamp: Time,
}

/// Which goals are to be cancelled: all of them with the zero id and stamp, [`CancelGoalRequest::default`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CancelGoalRequest {
    /// The goal.
    pub goal_info: GoalInfo,
}

/// What became of it.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CancelGoalResponse {
    /// 0: goals are cancelled; 1: refused; 2: no such goal; 3: it has ended.
    pub return_code: i8,
    /// Those that are being cancelled.
    pub goals_canceling: Vec<GoalInfo>,
}

impl CancelGoalResponse {
    /// No goal of the action is under way after it.
    pub fn is_done(&self) -> bool {
        self.return_code != 1
    }
}

ros_service! {
    /// Cancels goals: `<action>/_action/cancel_goal`.
    CancelGoal: action_msgs, CancelGoalRequest => CancelGoalResponse
}
