# Sourced by on-change and on-stale: asks Nav2 through `ros2`, and cancels every goal.

# A service that does not answer within this many seconds is not there.
call() {
    local service=$1 type=$2 request=$3 wanted=${4:-}
    local answer
    answer=$(timeout 10 ros2 service call "$service" "$type" "$request") || fail "$service does not answer"
    if [ -n "$wanted" ] && ! grep -q -- "$wanted" <<<"$answer"; then fail "$service refuses: $answer"; fi
}

# A zero goal id and stamp cancel every goal.
cancel_goals() {
    local action actions
    actions=$(timeout 10 ros2 action list) || fail "the actions of Nav2 cannot be listed"
    for action in navigate_to_pose navigate_through_poses follow_waypoints; do
        if grep -qx "/$action" <<<"$actions"; then
            call "/$action/_action/cancel_goal" action_msgs/srv/CancelGoal '{}'
        fi
    done
}

# tell TOPIC TEXT: a message for the mission planner.
tell() {
    timeout 10 ros2 topic pub --once "$1" std_msgs/msg/String "{data: '${2//\'/\'\'}'}" >/dev/null ||
        fail "$1 cannot be published"
}
