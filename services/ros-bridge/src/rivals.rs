//! Other nodes that publish on the topics of the maps.

use crate::graph::RosGraph;
use daemon::facts::RosPeers;
use diagnostics::counted;

/// What others have to do with the topics of the bridge.
pub(crate) struct Rivals {
    /// Topics on which the bridge publishes.
    published: Vec<String>,
    /// The topic of SLAM maps.
    taken: Option<String>,
    peers: RosPeers,
}

impl Rivals {
    /// Nobody is known yet.
    pub(crate) fn on(published: Vec<String>, taken: Option<String>) -> Self {
        Self { published, taken, peers: RosPeers::default() }
    }

    /// Looks at the graph.
    pub(crate) fn look(&mut self, graph: &RosGraph) {
        self.peers = graph.peers(self.published.iter().chain(&self.taken).map(String::as_str));
    }

    /// All that is there of others.
    pub(crate) fn peers(&self) -> &RosPeers {
        &self.peers
    }

    /// Publishers of others where the bridge publishes: a reader of a latched topic keeps the map of one of them.
    pub(crate) fn of_maps(&self) -> Option<String> {
        let (topic, n) = self.published.iter().map(|topic| (topic, self.publishers(topic))).find(|(_, n)| *n > 0)?;
        Some(format!("{} of other nodes on {topic}: readers keep one of them", counted(n, "publisher")))
    }

    /// Several that publish SLAM maps: each map that comes takes the place of the one before it, whoever publishes it.
    pub(crate) fn of_slam_maps(&self) -> Option<String> {
        let topic = self.taken.as_ref()?;
        let n = self.publishers(topic);
        (n > 1)
            .then(|| format!("{n} publishers on {topic}: the newest SLAM map is now that of one, now that of another"))
    }

    fn publishers(&self, topic: &str) -> usize {
        self.peers.topics.get(topic).map_or(0, |[publishers, _]| *publishers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn others_are_told_where_the_bridge_publishes_and_several_where_it_takes() {
        let mut rivals = Rivals::on(vec!["/map".to_owned(), "/mask".to_owned()], Some("/slam".to_owned()));
        let mut with = |topic: &str, publishers| {
            rivals.peers.topics = [(topic.to_owned(), [publishers, 5])].into();
            (rivals.of_maps(), rivals.of_slam_maps().is_some())
        };
        assert_eq!(with("/mask", 0), (None, false));
        assert!(with("/mask", 1).0.unwrap().starts_with("1 publisher of other nodes on /mask"));
        assert_eq!([with("/slam", 1), with("/slam", 2)], [(None, false), (None, true)]);
    }
}
