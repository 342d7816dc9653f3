//! Bits of an entropy-coded segment, the most significant first; a zero byte follows every 0xff (T.81, B.1.1.5).

/// Reads bits up to the next marker.
#[derive(Debug)]
pub(super) struct BitReader<'a> {
    bytes: &'a [u8],
    at: usize,
    held: u64,
    count: u32,
    /// Zero bits that were returned after the end.
    beyond: u32,
}

impl<'a> BitReader<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, held: 0, count: 0, beyond: 0 }
    }

    fn fill(&mut self) {
        while self.count <= 48 {
            let byte = match (self.bytes.get(self.at), self.bytes.get(self.at + 1)) {
                (Some(0xff), Some(0)) => {
                    self.at += 2;
                    0xff
                }
                // A marker, or the end: zeros, counted so that a short segment is noticed.
                (Some(0xff) | None, _) => {
                    self.beyond += 8;
                    0
                }
                (Some(&byte), _) => {
                    self.at += 1;
                    byte
                }
            };
            self.held = self.held << 8 | u64::from(byte);
            self.count += 8;
        }
    }

    /// The next 16 bits, not taken.
    pub(super) fn peek16(&mut self) -> u16 {
        if self.count < 16 {
            self.fill();
        }
        (self.held >> (self.count - 16)) as u16
    }

    /// Takes up to 16 bits.
    pub(super) fn take(&mut self, n: u32) -> u16 {
        if n == 0 {
            return 0;
        }
        let bits = self.peek16() >> (16 - n);
        self.count -= n;
        bits
    }

    /// Whether bits were taken that the segment does not have.
    pub(super) fn exhausted(&self) -> bool {
        self.beyond > self.count
    }

    /// Where the segment's marker is, when all but padding is taken.
    pub(super) fn marker_at(&self) -> usize {
        // Bytes that were read ahead lie before the marker, unless a marker has stopped the reading.
        let mut at = self.at;
        while self.bytes.get(at).is_some() {
            match (self.bytes.get(at), self.bytes.get(at + 1)) {
                (Some(0xff), Some(b)) if !matches!(b, 0 | 0xff) => return at,
                _ => at += 1,
            }
        }
        at
    }
}

/// Writes bits.
#[derive(Debug)]
pub(super) struct BitWriter {
    pub(super) bytes: Vec<u8>,
    held: u64,
    count: u32,
}

impl BitWriter {
    /// Continues after bytes that are already written.
    pub(super) fn after(bytes: Vec<u8>) -> Self {
        Self { bytes, held: 0, count: 0 }
    }

    pub(super) fn put(&mut self, value: u32, n: u32) {
        self.held = self.held << n | u64::from(value);
        self.count += n;
        while self.count >= 8 {
            self.count -= 8;
            let byte = (self.held >> self.count) as u8;
            self.bytes.push(byte);
            if byte == 0xff {
                self.bytes.push(0);
            }
        }
        self.held &= (1 << self.count) - 1;
    }

    /// Ends a segment: the last byte is filled up with ones.
    pub(super) fn flush(&mut self) {
        if self.count > 0 {
            let n = 8 - self.count;
            self.put((1 << n) - 1, n);
        }
    }
}
