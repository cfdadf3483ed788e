//! Disturbed records: the answers of our method and of others.

use super::lab::{Check, Lab, Section, Table};
use super::outcomes::{Outcomes, Shares};
use crate::arithmetic::Arithmetic;
use crate::campaign::{Campaign, Truth, command::SNR_DB};
use crate::estimator::{Estimator, parse};
use crate::impair::{Entry, Impairment, LIST};
use crate::simulate::Width;
use indicatif::ProgressBar;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::methods::registry::Records;
use picket_dsp::tone::fit::Reach;

/// Campaigns that [`impaired`] runs.
pub const IMPAIRED: u64 = (LIST.len() * SNR_DB.len()) as u64;
/// The methods beside ours.
const OTHERS: &str = "z-rife,quinn2,grandke,haqse";

/// Records of one impairment, all its severities alike, at one signal-to-noise ratio: the outcome of each method.
fn outcomes(lab: &Lab, entry: &Entry, snr_db: f64) -> Result<Vec<Shares>, String> {
    let iq = entry.records == Records::Iq;
    let severities = Impairment::parse(entry.name)?;
    let mut estimators = vec![Estimator::best(iq, Reach::Sixteen)];
    estimators.extend(parse(OTHERS, Reach::Sixteen)?);
    let campaign = Campaign {
        effort: picket_dsp::Effort::default(),
        arithmetic: Arithmetic::Target,
        n: 1024,
        trials: lab.trials(600, 24) / severities.len(),
        width: Width::Codes(Codes::signed::<12>()),
        amplitude: None,
        bins: None,
        truth: Truth::Mean,
        seed: lab.seed,
        estimators,
    };
    let mut counts = vec![[0; 3]; campaign.estimators.len()];
    for impairment in &severities {
        let bar = ProgressBar::hidden();
        let cells = with_kind!(iq, R => campaign.run::<R>(impairment, snr_db, &bar)?);
        for (counts, cell) in counts.iter_mut().zip(cells) {
            let new = [cell.right, cell.flagged, cell.overconfident];
            counts.iter_mut().zip(new).for_each(|(count, new)| *count += new);
        }
    }
    lab.bar.inc(1);
    let records = (campaign.trials * severities.len()) as f64;
    Ok(counts.into_iter().map(|counts| counts.map(|count| count as f64 / records)).collect())
}

/// Every impairment at three signal-to-noise ratios, beside four other methods.
pub fn impaired(lab: &Lab) -> Result<Section, String> {
    let others: Vec<&str> = OTHERS.split(',').collect();
    let methods = 1 + others.len();
    let mut rows = Vec::new();
    for entry in LIST {
        let mut cells = vec![[0.0; 3]; methods * SNR_DB.len()];
        for (column, &snr_db) in SNR_DB.iter().enumerate() {
            for (method, shares) in outcomes(lab, entry, snr_db)?.into_iter().enumerate() {
                cells[method * SNR_DB.len() + column] = shares;
            }
        }
        rows.push((entry.name.to_owned(), cells));
    }
    let percent = |share: f64| format!("{:.0}", 100.0 * share);
    let ratios = SNR_DB.map(|db| db.to_string()).join(" / ");
    let head = ["impairment".to_owned()]
        .into_iter()
        .chain(SNR_DB.map(|db| format!("ours at {db} dB: right / flagged / overconfident, %")))
        .chain(others.iter().map(|name| format!("{name}: overconfident at {ratios} dB, %")));
    let mut table = Table::new(head);
    for (name, cells) in &rows {
        let of = |method: usize| &cells[method * SNR_DB.len()..(method + 1) * SNR_DB.len()];
        let ours = of(0).iter().map(|shares| shares.map(percent).join(" / "));
        let overconfident = (1..methods)
            .map(|m| of(m).iter().map(|s| percent(s[2])).collect::<Vec<_>>().join(" / "));
        table.row([name.clone()].into_iter().chain(ours).chain(overconfident));
    }
    let checks = checks(lab, &rows, methods);
    let groups = std::iter::once("ours").chain(others).map(str::to_owned).collect();
    Ok(Section {
        title: "Records with something wrong: right, flagged, or overconfident",
        text: vec![
            format!(
                "Each row is one thing that front ends and signals do (`cargo lab sweep --impair list` explains them), at all its usual \
                 severities alike: {} records of 1024 samples of 12 bits at each signal-to-noise ratio, the firmware's arithmetic. \
                 Right: said to be usable within sigma (good, moving, clipped, gap), and within 5 sigma of the truth, which is the mean frequency over the block. Flagged: \
                 called anything else. Lie: said to be usable within sigma, and off by more.",
                lab.trials(600, 24)
            ),
            format!(
                "A share of {} records has a standard error of at most {:.1} %.",
                lab.trials(600, 24),
                50.0 / (lab.trials(600, 24) as f64).sqrt()
            ),
            "The others have the verdict of least squares, and a sigma that is no less than its sigma and than the distance between both answers.".into(),
        ],
        outcomes: Some(Outcomes {
            name: "impaired",
            title: "Records with something wrong: outcome by impairment and signal-to-noise ratio".into(),
            groups,
            columns: SNR_DB.map(|db| format!("{db} dB")).into(),
            rows,
        }),
        tables: vec![table],
        checks,
        ..Section::default()
    })
}

fn checks(lab: &Lab, rows: &[(String, Vec<Shares>)], methods: usize) -> Vec<Check> {
    let records = lab.trials(600, 24) as f64;
    let mut checks = Vec::new();
    for (column, snr_db) in SNR_DB.iter().enumerate() {
        let overconfident = |method: usize| {
            let cells = rows.iter().map(|(_, cells)| cells[method * SNR_DB.len() + column][2]);
            cells.sum::<f64>() / rows.len() as f64
        };
        let most = (1..methods).map(overconfident).fold(0.0, f64::max);
        // Three standard deviations of a share of one in a hundred.
        let chance = 3.0 * (0.01 / (records * rows.len() as f64)).sqrt();
        let figure = format!("overconfident share: the others' most less ours, {snr_db} dB");
        checks.push(Check::between(figure, most - overconfident(0), 0.0, -1.0, chance));
        for (_, cells) in rows.iter().filter(|(name, _)| name == "none") {
            let figure = format!("pure tones called right, {snr_db} dB");
            checks.push(Check::between(figure, cells[column][0], 0.0, 1.0 - 1.5 / records, 1.0));
        }
    }
    checks
}
