//! Options that would be ignored are refused, in one way for all commands.

use std::fmt::Display;

use super::exit::Stop;

/// The names of the options that were given, of pairs of both.
pub(super) fn given<const N: usize>(
    options: [(&'static str, bool); N],
) -> impl Iterator<Item = &'static str> {
    options.into_iter().filter_map(|(name, given)| given.then_some(name))
}

/// Refuses options that are for something else.
pub(super) fn refuse<'a>(
    given: impl IntoIterator<Item = &'a str>,
    are_for: impl Display,
) -> Result<(), Stop> {
    let given: Vec<_> = given.into_iter().collect();
    if given.is_empty() {
        return Ok(());
    }
    let are = if given.len() == 1 { "is" } else { "are" };
    Err(Stop::usage(format!("{} {are} for {are_for}", given.join(", "))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_are_for_something_else_are_named() {
        let said = |all| refuse(given(all), "graphs, which a.tif is not").map_err(|stop| stop.message);
        assert_eq!(said([("--a", false), ("--b", false)]), Ok(()));
        assert_eq!(
            said([("--a", true), ("--b", false)]),
            Err("--a is for graphs, which a.tif is not".into())
        );
        assert_eq!(
            said([("--a", true), ("--b", true)]),
            Err("--a, --b are for graphs, which a.tif is not".into())
        );
    }
}
