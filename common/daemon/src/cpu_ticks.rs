//! CPU times of a process or thread, as the system writes them.

/// The CPU times in a line of `/proc/PID/stat`, as it has them; the name in it may hold anything up to the last parenthesis.
pub(crate) fn cpu_ticks(stat: &str) -> String {
    let fields = stat.rsplit_once(')').map_or("", |(_, fields)| fields);
    fields.split_ascii_whitespace().skip(11).take(2).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cpu_times_are_found_behind_any_name() {
        let stat = "7 (a) b 1) S 1 2 3 4 5 6 7 8 9 10 14 15 16 17 20";
        assert_eq!(cpu_ticks(stat), "14 15");
        assert_eq!(cpu_ticks(""), "");
    }
}
