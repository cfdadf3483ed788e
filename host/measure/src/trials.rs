//! Trials over all cores: sums are taken in the order of trials, so the digits are the same on any number of threads.

use indicatif::ProgressBar;
use rayon::prelude::*;
use std::ops::AddAssign;

/// Trials to be made.
#[derive(Clone, Copy, Debug)]
pub struct Trials<'a> {
    /// How many.
    pub count: usize,
    /// How many one task takes, and sums in order.
    pub chunk: usize,
    /// Advances by one for each.
    pub bar: &'a ProgressBar,
}

impl Trials<'_> {
    /// Makes all trials, each by its number and on an engine of its thread's own. `trial` adds to one sum for each of `methods`.
    ///
    /// # Errors
    /// There is no such engine.
    pub fn sums<E: ?Sized, T>(
        &self,
        methods: usize,
        make: impl Fn() -> Result<Box<E>, String> + Send + Sync,
        trial: impl Fn(&mut E, usize, &mut [T]) + Send + Sync,
    ) -> Result<Vec<T>, String>
    where
        T: Clone + Default + Send + for<'t> AddAssign<&'t T>,
    {
        make()?;
        let sums = || vec![T::default(); methods];
        let chunks: Vec<usize> = (0..self.count).step_by(self.chunk).collect();
        let parts: Vec<Vec<T>> = chunks
            .into_par_iter()
            .map_init(&make, |engine, first| {
                let mut sums = sums();
                let last = self.count.min(first + self.chunk);
                if let Ok(engine) = engine {
                    (first..last).for_each(|number| trial(engine.as_mut(), number, &mut sums));
                }
                self.bar.inc((last - first) as u64);
                sums
            })
            .collect();
        let mut totals = sums();
        for part in &parts {
            totals.iter_mut().zip(part).for_each(|(total, part)| *total += part);
        }
        Ok(totals)
    }
}
