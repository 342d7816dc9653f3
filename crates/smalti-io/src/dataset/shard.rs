//! Shards, which divide a study among several runs.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// Shard `index` of `of`, written as `3/16`. It owns the chunks `c` with `c mod of = index − 1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shard {
    index: u32,
    of: u32,
}

/// An invalid shard.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ShardError {
    /// The text is not two numbers separated by a slash.
    #[error("shard is {text:?}; expected INDEX/COUNT, such as 3/16")]
    Format {
        /// The text.
        text: String,
    },
    /// The index is not between 1 and the number of shards.
    #[error("shard is {index}/{of}; expected 1/{last} to {last}/{last}", last = (*.of).max(1))]
    Range {
        /// The index.
        index: u32,
        /// The number of shards.
        of: u32,
    },
}

impl Shard {
    /// Shard `index` of `of`, with `index` from 1 to `of`.
    ///
    /// # Errors
    /// [`ShardError::Range`].
    pub fn new(index: u32, of: u32) -> Result<Self, ShardError> {
        if index == 0 || index > of { Err(ShardError::Range { index, of }) } else { Ok(Self { index, of }) }
    }

    /// Index, from 1.
    #[must_use]
    pub fn index(self) -> u32 {
        self.index
    }

    /// Number of shards.
    #[must_use]
    pub fn of(self) -> u32 {
        self.of
    }

    /// Whether a chunk belongs to this shard.
    #[must_use]
    pub fn owns(self, chunk: u64) -> bool {
        chunk % u64::from(self.of) == u64::from(self.index - 1)
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        // `parse` alone would accept a plus sign.
        let number = |s: &str| s.parse().ok().filter(|_: &u32| s.bytes().all(|b| b.is_ascii_digit()));
        let numbers = text.split_once('/').and_then(|(i, n)| Some((number(i)?, number(n)?)));
        let (index, of) = numbers.ok_or_else(|| ShardError::Format { text: text.to_owned() })?;
        Self::new(index, of)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_out_all_chunks_without_overlap() {
        let shards: Vec<Shard> = (1..=5).map(|i| Shard::new(i, 5).unwrap()).collect();
        for chunk in 0..23 {
            assert_eq!(shards.iter().filter(|s| s.owns(chunk)).count(), 1);
        }
        assert!(shards[2].owns(7) && "3/5".parse::<Shard>().unwrap() == shards[2]);
        assert_eq!(shards[2].to_string(), "3/5");
    }

    #[test]
    fn what_is_no_shard_is_said() {
        for text in ["", "3", "3/", "/3", "a/b", "1/2/3", "-1/2", "+1/2", "1 / 2", "5000000000/5000000000"] {
            let error = text.parse::<Shard>().unwrap_err().to_string();
            assert_eq!(error, format!("shard is {text:?}; expected INDEX/COUNT, such as 3/16"));
        }
        for (text, last) in [("0/4", 4), ("5/4", 4), ("0/0", 1), ("1/0", 1)] {
            let error = text.parse::<Shard>().unwrap_err().to_string();
            assert_eq!(error, format!("shard is {text}; expected 1/{last} to {last}/{last}"));
        }
    }
}
