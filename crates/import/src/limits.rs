//! How much of what a file or an FMU says is taken; more is refused with its number.

/// Files and folders in an archive.
pub(super) const MOST_ENTRIES: usize = 100_000;
/// Bytes of an archive that is read whole.
pub(super) const MOST_PACKED: u64 = 1 << 30;
/// Bytes of an archive, unpacked.
pub(super) const MOST_UNPACKED: u64 = 1 << 30;
/// Bytes of `modelDescription.xml`.
pub(super) const LONGEST_DESCRIPTION: u64 = 1 << 28;
/// Variables of an FMU.
pub(super) const MOST_VARIABLES: usize = 1_000_000;
/// Elements of the description inside one another.
pub(super) const DEEPEST: usize = 100;
/// Messages that an error quotes: the newest.
pub(super) const MOST_COMPLAINTS: usize = 10;
/// Bytes of a request to an FMU's process, or of an answer: a state is the longest.
#[cfg(unix)]
pub(super) const LONGEST_FRAME: usize = 1 << 28;
