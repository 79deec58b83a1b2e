//! Readers and writers of height and picture files.
