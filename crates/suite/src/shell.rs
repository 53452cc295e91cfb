//! Commands as they would be typed.

/// An argument as a shell takes it again.
pub fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        return argument.into();
    }
    format!("'{}'", argument.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn the_command_can_be_pasted_into_a_shell() {
        assert_eq!(quoted("--knob=a,b"), "--knob=a,b");
        assert_eq!(quoted("vsm/*"), "'vsm/*'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
