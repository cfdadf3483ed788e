//! The registry of methods: one line each.

/// A method by which the offset from the peak bin is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// [`super::rife::rife`].
    Rife,
    /// [`super::rife::z_rife`].
    #[default]
    ZRife,
}
