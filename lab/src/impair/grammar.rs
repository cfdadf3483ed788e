//! Impairments as a user types them: `chirp`, `chirp:0.3`, `second-tone:offset=0.5/1,level-db=-20,hum`, and pairs of them:
//! `chirp:0.3+hum`.

use super::list::{Concerns, Entry, GROUPS, Key};
use super::{Impairment, Part};
use picket_dsp::methods::registry::Records;

/// More than anybody wants to wait for.
const MOST: usize = 10_000;

/// An impairment and the severities of each of its keys.
type Grid = (&'static Entry, Vec<Vec<f64>>);

pub(super) fn parse(text: &str) -> Result<Vec<Impairment>, String> {
    let mut chosen: Vec<Vec<Grid>> = Vec::new();
    // Whether the last word was a name: keys belong to it, and others may be joined to it.
    let mut named = false;
    for (joined, word) in words(text) {
        let mut last = chosen.last_mut().filter(|_| named);
        if let Some((_, entries, _)) = GROUPS.iter().find(|group| group.0 == word) {
            if joined {
                return Err(many(word));
            }
            chosen.extend(entries.iter().map(|entry| vec![(entry, entry.defaults())]));
            named = false;
            continue;
        }
        // What has a key and no name belongs to the name before it.
        if word.contains('=')
            && !word.contains(':')
            && !joined
            && let Some((entry, values)) = last.as_mut().and_then(|grids| grids.last_mut())
        {
            set(entry, word, values)?;
            continue;
        }
        let (name, first) = word.split_once(':').map_or((word, None), |(n, f)| (n, Some(f)));
        let mut entries = GROUPS.iter().flat_map(|(_, entries, _)| entries.iter());
        let entry = entries
            .find(|entry| entry.name == name)
            .ok_or_else(|| format!("no impairment \"{name}\": --impair list shows them"))?;
        let mut values = entry.defaults();
        first.map(|word| set(entry, word, &mut values)).transpose()?;
        match last {
            _ if !joined => chosen.push(vec![(entry, values)]),
            Some(grids) => grids.push((entry, values)),
            None => return Err(many("a list")),
        }
        named = true;
    }
    let count = |grids: &Vec<Grid>| {
        let lengths = grids.iter().flat_map(|(_, values)| values.iter().map(Vec::len));
        lengths.fold(1, usize::saturating_mul)
    };
    if chosen.iter().map(count).fold(0, usize::saturating_add) > MOST {
        return Err(format!("more than {MOST} severities: give fewer values"));
    }
    for grids in &chosen {
        let entries: Vec<&Entry> = grids.iter().map(|(entry, _)| *entry).collect();
        fit_together(&entries)?;
    }
    Ok(chosen.iter().flat_map(|grids| grid(grids)).collect())
}

fn many(word: &str) -> String {
    format!("{word} is many impairments: join two by their names")
}

/// The words of a list, each with whether a plus joins it to the one before. A plus before a digit belongs to a number.
fn words(text: &str) -> Vec<(bool, &str)> {
    let (mut words, mut begin, mut joined) = (Vec::new(), 0, false);
    for (at, separator) in text.match_indices([',', '+']) {
        let rest = text[at + 1..].trim_start();
        if separator == "+" && rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            continue;
        }
        words.push((joined, text[begin..at].trim()));
        (begin, joined) = (at + 1, separator == "+");
    }
    words.push((joined, text[begin..].trim()));
    words
}

/// Whether one record can have these impairments; else why not, and what to do.
fn fit_together(entries: &[&Entry]) -> Result<(), String> {
    let (a, b) = match entries {
        [_] => return Ok(()),
        [a, b] => (*a, *b),
        _ => return Err("a record has two impairments at most: join two names".into()),
    };
    let [first, second] = [a.name, b.name];
    let apart = |why: String| Err(format!("{first}+{second}: {why}"));
    if a == b {
        return apart(format!("a record has {first} once: join it to another one"));
    }
    for (one, other) in [(a, b), (b, a)] {
        let [name, beside] = [one.name, other.name];
        if name == "none" {
            return apart(format!("none adds nothing: {beside} alone is the same"));
        }
        if one.noiseless && other.concerns == Concerns::Noise {
            return apart(format!("{name} has no noise: join {beside} to another one"));
        }
        if one.records == Records::Real && other.records == Records::Iq {
            return apart(format!(
                "{name} is of real records, {beside} of I/Q: sweep them one by one"
            ));
        }
    }
    if a.concerns == Concerns::Level && b.concerns == Concerns::Level {
        return apart("both say how strong the tone is: join either to another one".into());
    }
    Ok(())
}

/// `KEY=VALUE/VALUE`, or values alone for the first key.
fn set(entry: &Entry, word: &str, values: &mut [Vec<f64>]) -> Result<(), String> {
    let name = entry.name;
    let (key, list) = word.split_once('=').map_or((None, word), |(key, list)| (Some(key), list));
    let known = || -> Vec<&str> { entry.keys.iter().map(|key| key.name).collect() };
    let place = match key {
        None => (!entry.keys.is_empty()).then_some(0),
        Some(key) => {
            entry.keys.iter().position(|k| k.name == key || k.json() == key.replace('-', "_"))
        }
    };
    let place = place.ok_or_else(|| match known()[..] {
        [] => format!("{name} has no severities: leave \"{word}\" out"),
        _ => format!("{name} has no \"{}\", but {}", key.unwrap_or(word), known().join(", ")),
    })?;
    values[place] = list
        .split('/')
        .map(|text| value(name, &entry.keys[place], text))
        .collect::<Result<_, _>>()?;
    Ok(())
}

fn value(name: &str, key: &Key, text: &str) -> Result<f64, String> {
    let (least, most) = key.range;
    match text.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("{name}: {}={text}: give a number from {least} to {most}", key.name)),
    }
}

/// Every combination of the severities, of one impairment or of a pair.
pub(super) fn grid(grids: &[Grid]) -> Vec<Impairment> {
    // Each combination so far, longer by each choice of what follows.
    fn longer<T: Clone>(rows: Vec<Vec<T>>, choices: &[T]) -> Vec<Vec<T>> {
        let each = |row: Vec<T>| {
            choices
                .iter()
                .map(move |choice| [row.as_slice(), std::slice::from_ref(choice)].concat())
        };
        rows.into_iter().flat_map(each).collect()
    }
    let of = |(entry, values): &Grid| -> Vec<Part> {
        let rows = values.iter().fold(vec![Vec::new()], |rows, values| longer(rows, values));
        rows.into_iter().map(|values| Part { entry, values }).collect()
    };
    let rows = grids.iter().map(of).fold(vec![Vec::new()], |rows, parts| longer(rows, &parts));
    rows.into_iter().map(|parts| Impairment { parts }).collect()
}

/// Every impairment with its keys and their severities, as a list for people.
pub fn help() -> String {
    let line = |entry: &Entry| {
        let records = match entry.records {
            Records::Iq => " (I/Q only)",
            _ => "",
        };
        let keys = entry.keys.iter().map(|key| {
            let values: Vec<String> = key.usual.iter().map(f64::to_string).collect();
            let unit = if key.json() == key.name.replace('-', "_") { "" } else { key.unit };
            format!("  {}={} {unit}", key.name, values.join("/")).trim_end().to_owned()
        });
        let keys = keys.collect::<String>();
        let gap = if keys.is_empty() {
            String::new()
        } else {
            format!("\n  {:<17}{}", "", keys.trim_start())
        };
        format!("  {:<17}{}{records}{gap}\n", entry.name, entry.doc)
    };
    let group = |(_, entries, title): &(&str, &[Entry], &str)| {
        format!("{title}\n{}", entries.iter().map(line).collect::<String>())
    };
    GROUPS.iter().map(group).collect::<String>()
        + "Two of any list in one record: chirp:0.3+hum, each with its severities.\n"
}
