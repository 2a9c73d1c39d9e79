//! How unlikely it is that values of elements are values of tasks by chance, in bits.
//!
//! - Texts are of one form if they differ in their last number alone: `w-17` and `w-23`. A number of a form counts for
//!   `log2(numbers between the least and the greatest of the tasks / numbers that tasks have)` bits: nothing where tasks have all of them.
//! - Numbers alone are compared with those of as many trailing zeros only, since measures and codes are both round.
//! - The first text of a form counts for its letters besides: 4 bits each, 2 where it has no digit, since words are common; at most 20.
//! - Values that are those of work, and not of summaries and milestones as well, count by how much more often they are.

use std::collections::{BTreeMap, BTreeSet};

/// Bits of the letters of a form.
const MAX_FORM_BITS: f64 = 20.0;
/// Digits of the longest number; longer ones are letters.
const MAX_DIGITS: usize = 15;

/// A text without its last number.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Form {
    before: String,
    after: String,
    /// Digits of a number with leading zeros; 0 for others.
    width: usize,
    /// It is a number, with so many decimals.
    decimals: Option<usize>,
}

/// Values of tasks by their forms.
#[derive(Debug, Default)]
pub(super) struct Forms {
    numbers: BTreeMap<Form, BTreeSet<u64>>,
    /// How many numbers of a form are multiples of a power of ten.
    multiples: BTreeMap<Form, BTreeMap<u64, usize>>,
    n_work: usize,
    n_all: usize,
}

impl Forms {
    /// Of the distinct values of tasks, with whether a task with it is work.
    pub(super) fn of<'t>(values: impl Iterator<Item = (&'t str, bool)>) -> Self {
        let mut forms = Self::default();
        for (text, is_work) in values {
            let (form, number) = form_of(text);
            let multiples = forms.multiples.entry(form.clone()).or_default();
            if forms.numbers.entry(form).or_default().insert(number) {
                let steps = std::iter::successors(Some(1_u64), |step| step.checked_mul(10));
                steps
                    .take_while(|step| *step == 1 || number > 0 && number % step == 0)
                    .for_each(|step| *multiples.entry(step).or_default() += 1);
            }
            forms.n_all += 1;
            forms.n_work += usize::from(is_work);
        }
        forms
    }

    /// True if the values are the whole numbers from 1, or nearly all of them: numbers of rows.
    pub(super) fn is_numbering(&self) -> bool {
        let whole = |(form, numbers): (&Form, &BTreeSet<u64>)| {
            let last = numbers.last().copied().unwrap_or(0);
            form.decimals == Some(0)
                && numbers.first().is_some_and(|first| *first <= 1)
                && numbers.len() as u64 * 10 >= last * 9
        };
        self.numbers.iter().any(whole)
    }

    /// Bits of values that elements have, too, with whether a task with it is work.
    pub(super) fn bits<'t>(&self, shared: impl Iterator<Item = (&'t str, bool)>) -> f64 {
        let mut bits = 0.0;
        let mut met = BTreeSet::new();
        let (mut n, mut n_work) = (0, 0);
        for (text, is_work) in shared {
            let (form, number) = form_of(text);
            bits += self.number_bits(&form, number);
            if !met.contains(&form) {
                bits += form_bits(&form);
                met.insert(form);
            }
            n += 1;
            n_work += usize::from(is_work);
        }
        bits + self.work_bits(n, n_work)
    }

    fn number_bits(&self, form: &Form, number: u64) -> f64 {
        let Some(numbers) = self.numbers.get(form) else { return 0.0 };
        let step = if form.decimals.is_some() { trailing(number) } else { 1 };
        let (Some(first), Some(last)) = (numbers.first(), numbers.last()) else { return 0.0 };
        let n_possible = last / step - first.div_ceil(step) + 1;
        let n_taken = self.multiples.get(form).and_then(|of| of.get(&step)).copied().unwrap_or(1);
        (n_possible as f64 / n_taken as f64).log2().max(0.0)
    }

    /// Relative entropy of the share of work among values, against that among all values of tasks.
    fn work_bits(&self, n: usize, n_work: usize) -> f64 {
        if n == 0 || self.n_work == 0 || self.n_work == self.n_all {
            return 0.0;
        }
        let (share, usual) = (n_work as f64 / n as f64, self.n_work as f64 / self.n_all as f64);
        if share <= usual {
            return 0.0;
        }
        let part = |p: f64, q: f64| if p > 0.0 { p * (p / q).log2() } else { 0.0 };
        n as f64 * (part(share, usual) + part(1.0 - share, 1.0 - usual))
    }
}

/// The largest power of ten in a number.
fn trailing(number: u64) -> u64 {
    let powers = std::iter::successors(Some(1_u64), |power| power.checked_mul(10));
    powers.take_while(|power| number > 0 && number.is_multiple_of(*power)).last().unwrap_or(1)
}

fn form_bits(form: &Form) -> f64 {
    if form.decimals.is_some() {
        return 0.0;
    }
    let texts = || form.before.chars().chain(form.after.chars());
    let has_digits = form.width > 0 || texts().any(|c| c.is_ascii_digit()) || form.after.starts_with('\u{0}');
    let per_letter = if has_digits { 4.0 } else { 2.0 };
    (texts().filter(|c| c.is_alphanumeric()).count() as f64 * per_letter).min(MAX_FORM_BITS)
}

/// A text as its form and its last number; a text without a number is a form of its own.
fn form_of(text: &str) -> (Form, u64) {
    let end = text.rfind(|c: char| c.is_ascii_digit()).map_or(0, |at| at + 1);
    let start = text[..end]
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |at| at + text[at..].chars().next().map_or(1, char::len_utf8));
    let digits = &text[start..end];
    let whole = || Form { before: text.to_owned(), after: String::new(), width: 0, decimals: None };
    let Some(number) = digits.parse::<u64>().ok().filter(|_| digits.len() <= MAX_DIGITS) else { return (whole(), 0) };
    // `1.2` is a number of tenths.
    if end == text.len() && text[..start].chars().all(|c| c.is_ascii_digit() || c == '.') {
        let decimals = if start == 0 { Some(0) } else { Some(digits.len()).filter(|_| text.matches('.').count() == 1) };
        let scaled = text.replace('.', "").parse::<u64>().ok().filter(|_| text.len() <= MAX_DIGITS);
        if let (Some(decimals), Some(scaled)) = (decimals, scaled) {
            let form = Form { before: String::new(), after: String::new(), width: 0, decimals: Some(decimals) };
            return (form, scaled);
        }
    }
    let width = if digits.len() > 1 && digits.starts_with('0') { digits.len() } else { 0 };
    // A mark that the number stood here.
    let form =
        Form { before: text[..start].to_owned(), after: format!("\u{0}{}", &text[end..]), width, decimals: None };
    (form, number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(tasks: &[String], shared: &[String]) -> f64 {
        Forms::of(tasks.iter().map(|t| (t.as_str(), true))).bits(shared.iter().map(|t| (t.as_str(), true)))
    }

    fn texts(numbers: impl Iterator<Item = usize>, before: &str) -> Vec<String> {
        numbers.map(|k| format!("{before}{k}")).collect()
    }

    #[test]
    fn numbers_of_rows_say_nothing_and_codes_do() {
        let rows = texts(1..=200, "");
        assert!(bits(&rows, &rows) < 1.0);
        assert!(Forms::of(rows.iter().map(|t| (t.as_str(), true))).is_numbering());
        // Round measures are round codes.
        let codes = texts((1000..3000).step_by(10), "");
        assert!(bits(&codes, &texts((1000..3000).step_by(100), "")) < 5.0);
        let lettered = texts((1000..3000).step_by(10), "a");
        assert!(bits(&lettered, &lettered) > 500.0);
        assert!(bits(&["walls".to_owned()], &["walls".to_owned()]) == 10.0);
        let ids = ["0k2eqc$9h5vrd1", "1pl9xz$kk3dwwa"].map(str::to_owned);
        assert!(bits(&ids, &ids) >= 40.0);
    }

    #[test]
    fn values_of_work_alone_tell_more() {
        let rows: Vec<String> = texts(1..=100, "");
        let forms = Forms::of(rows.iter().enumerate().map(|(k, text)| (text.as_str(), k % 4 > 0)));
        let work = rows.iter().enumerate().filter(|(k, _)| k % 4 > 0).map(|(_, text)| (text.as_str(), true));
        assert!(forms.bits(work) > 30.0);
        let any = rows.iter().enumerate().map(|(k, text)| (text.as_str(), k % 4 > 0));
        assert!(forms.bits(any) < 1.0);
    }

    #[test]
    fn the_form_of_a_text_is_what_stands_around_its_last_number() {
        assert_eq!(form_of("w-17").0, form_of("w-23").0);
        assert_ne!(form_of("w-17").0, form_of("v-17").0);
        assert_eq!(
            form_of("1.2"),
            (Form { before: String::new(), after: String::new(), width: 0, decimals: Some(1) }, 12)
        );
        assert_eq!(form_of("ä1ö").1, 1);
        assert_eq!((trailing(1200), trailing(7), trailing(0)), (100, 1, 1));
    }
}
