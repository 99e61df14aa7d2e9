//! Words and numbers of text, and where in the file they stand.

/// The words of a text, one after the other.
pub struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// Begins a comment, up to the end of the line.
    comment: Option<u8>,
}

impl<'a> Words<'a> {
    /// The words of `bytes`, from the first line on.
    pub fn new(bytes: &'a [u8]) -> Words<'a> {
        Words { bytes, at: 0, line: 1, comment: None }
    }

    /// The same, without what follows a `comment` on its line.
    pub fn without_comments(bytes: &'a [u8], comment: u8) -> Words<'a> {
        Words { comment: Some(comment), ..Words::new(bytes) }
    }

    /// The same, with `line` as the number of the first line.
    pub fn counting_from(self, line: usize) -> Words<'a> {
        Words { line, ..self }
    }

    /// The line, counted from 1, of the word that `next` gave last.
    pub fn line(&self) -> usize {
        self.line
    }

    /// Bytes that are left.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Goes on `count` bytes further, if there are so many; they are no text.
    pub fn skip(&mut self, count: usize) -> Option<&'a [u8]> {
        let skipped = self.bytes[self.at..].get(..count)?;
        self.at += count;
        Some(skipped)
    }

    /// The next word.
    pub fn next(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks(true);
        self.word()
    }

    /// The next word, unless it stands on a later line.
    pub fn next_on_line(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks(false);
        self.word()
    }

    /// Without going on.
    pub fn peek(&mut self) -> Option<&'a [u8]> {
        let (at, line) = (self.at, self.line);
        let word = self.next();
        (self.at, self.line) = (at, line);
        word
    }

    /// The rest of the line; goes on to the next.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += end;
        if self.at < self.bytes.len() {
            self.at += 1;
            self.line += 1;
        }
        rest[..end].trim_ascii()
    }

    /// A number; `what` says in an error what it is part of.
    pub fn real(&mut self, what: &str) -> Result<f64, String> {
        let word = self.expect(what)?;
        real(word).ok_or_else(|| format!("line {}: {what} needs a number, not {}", self.line, quoted(word)))
    }

    /// A whole number of at least 0.
    pub fn count(&mut self, what: &str) -> Result<usize, String> {
        let word = self.expect(what)?;
        count(word).ok_or_else(|| format!("line {}: {what} needs a whole number, not {}", self.line, quoted(word)))
    }

    /// A point.
    pub fn point(&mut self, what: &str) -> Result<glam::DVec3, String> {
        Ok(glam::DVec3::new(self.real(what)?, self.real(what)?, self.real(what)?))
    }

    /// A word, which must be there.
    pub fn expect(&mut self, what: &str) -> Result<&'a [u8], String> {
        self.next().ok_or_else(|| format!("line {}: the file ends within {what}", self.line))
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|&b| b.is_ascii_whitespace() || Some(b) == self.comment).unwrap_or(rest.len());
        self.at += end;
        (end > 0).then(|| &rest[..end])
    }

    fn skip_blanks(&mut self, lines: bool) {
        while let Some(&byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' if !lines => return,
                b'\n' => self.line += 1,
                _ if byte.is_ascii_whitespace() => {}
                _ if Some(byte) == self.comment => {
                    let rest = &self.bytes[self.at..];
                    self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                    continue;
                }
                _ => return,
            }
            self.at += 1;
        }
    }
}

/// The number that a word is, correctly rounded.
pub fn real(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The whole number that a word is.
pub fn count(word: &[u8]) -> Option<usize> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A word for a message: short, and on one line whatever it holds.
pub fn quoted(word: &[u8]) -> String {
    const LONGEST: usize = 30;
    let text: String = String::from_utf8_lossy(word).chars().take(LONGEST).collect();
    format!("{text:?}")
}
