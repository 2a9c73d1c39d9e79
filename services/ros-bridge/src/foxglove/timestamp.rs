//! Stamps of messages as entities of a scene have them.

use foxglove::messages::Timestamp;
use ros::msg::std_msgs::Header;

/// The stamp of a header; what is before 1970 has the seconds 0.
pub(super) fn timestamp(header: &Header) -> Option<Timestamp> {
    Timestamp::new_checked(u32::try_from(header.stamp.sec).unwrap_or_default(), header.stamp.nanosec)
}
