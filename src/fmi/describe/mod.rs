//! The XML and the documentation.
