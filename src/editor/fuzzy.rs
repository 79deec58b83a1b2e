//! Fuzzy search: scores for a few typed letters against a text.

/// The score of a query against a name: higher is better, `None` where the name lacks its letters in their order.
pub(crate) fn score(query: &str, text: &str) -> Option<i32> {
    let lower = |s: &str| -> Vec<char> { s.chars().flat_map(char::to_lowercase).collect() };
    let letters = lower(text);
    let wanted: Vec<char> = lower(query).into_iter().filter(|c| !c.is_whitespace() && *c != '_').collect();
    let starts = |i: usize| i == 0 || !letters[i - 1].is_alphanumeric();
    let whole = || letters.windows(wanted.len().max(1)).enumerate().filter(|(_, w)| *w == wanted);
    let at_start = whole().any(|(i, _)| starts(i));
    let total = match (at_start, whole().next()) {
        (true, _) => 10 * wanted.len() as i32 + 20,
        (false, Some(_)) => 8 * wanted.len() as i32 + 6,
        (false, None) => scattered(&wanted, &letters, starts)?,
    };
    Some(total * 4 - letters.len() as i32)
}

/// The score of letters that occur in order with others between them; letters at the starts of words count most.
fn scattered(wanted: &[char], letters: &[char], starts: impl Fn(usize) -> bool) -> Option<i32> {
    let (mut total, mut from) = (0, 0);
    for letter in wanted {
        let places = || (from..letters.len()).filter(|i| letters[*i] == *letter);
        let at = places().find(|i| starts(*i)).or_else(|| places().next())?;
        total += if starts(at) { 6 } else { 1 };
        from = at + 1;
    }
    Some(total)
}

/// The best score of a query against a name and its synonyms, which count less. A name within two typing errors of a
/// query of four letters or more scores 0.
pub(crate) fn best<'a>(query: &str, name: &str, words: impl IntoIterator<Item = &'a str>) -> Option<i32> {
    let own = score(query, name).map(|s| s + 40);
    let others = words.into_iter().filter_map(|word| score(query, word));
    let slip = || {
        let distance = strsim::damerau_levenshtein(&query.to_lowercase(), name);
        (query.len() > 3 && distance <= 2).then_some(0)
    };
    own.into_iter().chain(others).max().or_else(slip)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_come_in_order() {
        assert!(score("fn", "fractal_noise").is_some());
        assert!(score("nf", "fractal_noise").is_none());
        assert!(score("", "blur").is_some());
    }

    #[test]
    fn names_before_synonyms_and_starts_before_middles() {
        let rank = |query: &str| {
            let kinds = crate::nodes::Registry::standard();
            let fit = |k: &crate::node::Kind| best(query, &k.id, k.keywords.iter().map(|word| word.as_str()));
            let mut found: Vec<_> = kinds.iter().filter_map(|k| Some((-fit(k)?, k.id.to_string()))).collect();
            found.sort();
            found.first().map(|(_, id)| id.clone())
        };
        assert_eq!(rank("blur").as_deref(), Some("blur"));
        assert_eq!(rank("fn").as_deref(), Some("fractal_noise"));
        assert_eq!(rank("slope").as_deref(), Some("select_slope"));
        assert_eq!(rank("unsharp").as_deref(), Some("sharpen"));
        assert_eq!(rank("blurr").as_deref(), Some("blur"));
    }
}
