//! Impairments as a user types them: `chirp`, `chirp:0.3`, `second-tone:offset=0.5/1,level-db=-20,hum`.

use super::Impairment;
use super::list::{Entry, FRONT_END, Key, LIST};
use picket::methods::registry::Records;

/// More than anybody wants to wait for.
const MOST: usize = 10_000;

pub(super) fn parse(text: &str) -> Result<Vec<Impairment>, String> {
    let mut all = Vec::new();
    let mut words = text.split(',').map(str::trim).peekable();
    while let Some(word) = words.next() {
        if word == "all" {
            all.extend(Impairment::all());
            continue;
        }
        if word == "front-end" {
            all.extend(Impairment::front_end());
            continue;
        }
        let (name, first) = word.split_once(':').map_or((word, None), |(n, f)| (n, Some(f)));
        let entry = LIST
            .iter()
            .chain(FRONT_END)
            .find(|entry| entry.name == name)
            .ok_or_else(|| format!("no impairment \"{name}\": --impair list shows them"))?;
        let mut values = entry.defaults();
        let first = first.map(|word| set(entry, word, &mut values));
        first.transpose()?;
        // What has a key and no name belongs to the name before it.
        while let Some(word) = words.next_if(|word| word.contains('=') && !word.contains(':')) {
            set(entry, word, &mut values)?;
        }
        all.extend(grid(entry, &values));
        if all.len() > MOST {
            return Err(format!("more than {MOST} severities: give fewer values"));
        }
    }
    Ok(all)
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

/// Every combination of the values of the keys.
pub(super) fn grid(entry: &'static Entry, values: &[Vec<f64>]) -> Vec<Impairment> {
    let combine = |rows: Vec<Vec<f64>>, values: &Vec<f64>| -> Vec<Vec<f64>> {
        let longer = |row: Vec<f64>| {
            values.iter().map(move |&value| row.iter().copied().chain([value]).collect())
        };
        rows.into_iter().flat_map(longer).collect()
    };
    let rows = values.iter().fold(vec![Vec::new()], combine);
    rows.into_iter().map(|values| Impairment { entry, values }).collect()
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
    "Impairments, with the severities they have unless told otherwise:\n".to_owned()
        + &LIST.iter().map(line).collect::<String>()
        + "Faults of a digital front end, no part of \"all\"; \"front-end\" is every one:\n"
        + &FRONT_END.iter().map(line).collect::<String>()
}
