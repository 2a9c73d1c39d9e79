//! Questions of viewers about the site, in their words.

use answers::{FindError, Situation, door, find_door, find_place, find_room, room, way};
use serde::Serialize;

/// A question.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Question {
    /// Where a room is, whether this robot may enter it, and what is in it.
    Room(String),
    /// Where a door is, and whether this robot can pass it.
    Door(String),
    /// The way from a room or point to another.
    Way([String; 2]),
}

/// An answer for programs, and for people.
#[derive(Debug, Serialize)]
struct Told<A> {
    answer: A,
    text: String,
}

/// Longest name of a room, door or point, in bytes.
const MAX_NAME_BYTES: usize = 400;

impl Question {
    /// False if a name is longer than any may be.
    pub(crate) fn is_short(&self) -> bool {
        self.names().iter().all(|name| name.len() <= MAX_NAME_BYTES)
    }

    /// The command of the client that asks the same of model files.
    pub(crate) fn command(&self, models: &str) -> String {
        let word = match self {
            Self::Room(_) => "room",
            Self::Door(_) => "door",
            Self::Way(_) => "way",
        };
        let quoted: Vec<String> =
            self.names().iter().map(|name| format!("'{}'", name.replace('\'', "'\\''"))).collect();
        format!("groundplan {word} {} {models} --date DATE", quoted.join(" "))
    }

    fn names(&self) -> &[String] {
        match self {
            Self::Room(name) | Self::Door(name) => std::slice::from_ref(name),
            Self::Way(ends) => ends,
        }
    }

    /// The answer in a situation, as JSON: `answer` is what the client prints with `--json`, `text` what it prints without.
    ///
    /// # Errors
    /// Names that stand for nothing, or for several things.
    pub(crate) fn answer(&self, situation: &Situation<'_>) -> Result<Vec<u8>, FindError> {
        let site = situation.site;
        Ok(match self {
            Self::Room(name) => {
                let answer = room(situation, find_room(site, name)?);
                told(answer.text(), answer)
            }
            Self::Door(name) => {
                let answer = door(situation, find_door(site, name)?);
                told(answer.text(), answer)
            }
            Self::Way([from, to]) => {
                let answer = way(situation, &find_place(site, from)?, &find_place(site, to)?);
                told(answer.text(), answer)
            }
        })
    }
}

fn told(text: String, answer: impl Serialize) -> Vec<u8> {
    serde_json::to_vec(&Told { answer, text }).expect("keys are texts, and numbers are finite")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_quotes_what_viewers_write() {
        let way = Question::Way(["Lab 3".to_owned(), "it's".to_owned()]);
        assert_eq!(way.command("a.ifc"), "groundplan way 'Lab 3' 'it'\\''s' a.ifc --date DATE");
        assert!(way.is_short() && !Question::Door("x".repeat(401)).is_short());
    }
}
