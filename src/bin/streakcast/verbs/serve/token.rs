//! The token that the API asks for: from a file or an environment variable, never from the command line.

use std::net::SocketAddr;

use anyhow::anyhow;
use subtle::ConstantTimeEq;

use super::arguments::ServeArguments;

/// Shorter ones are guessed.
const SHORTEST: usize = 16;
const LONGEST: usize = 512;

/// A secret of the server; it is never shown.
pub struct Token(Vec<u8>);

impl Token {
    /// The token as the flags name it; none on loopback where none is named.
    pub fn of(typed: &ServeArguments) -> anyhow::Result<Option<Self>> {
        let text = match (&typed.token_file, &typed.token_env) {
            (Some(path), _) => {
                let text = std::fs::read_to_string(path)
                    .map_err(|error| anyhow!("cannot read the token of {}: {error}", path.display()))?;
                text.lines().next().unwrap_or_default().trim().to_owned()
            }
            (None, Some(name)) => std::env::var(name)
                .map_err(|_| anyhow!("environment variable {name} holds no token"))?
                .trim()
                .to_owned(),
            (None, None) => return needless(typed.bind).map(|()| None),
        };
        if !(SHORTEST..=LONGEST).contains(&text.len()) || !text.bytes().all(|byte| byte.is_ascii_graphic()) {
            let letters = text.chars().count();
            return Err(anyhow!(
                "a token of {letters} letters; allowed: {SHORTEST} to {LONGEST} letters, digits and marks without blanks"
            ));
        }
        Ok(Some(Self(text.into_bytes())))
    }

    /// Whether an Authorization header carries it, in a time that does not tell how much of it is right.
    pub fn is_carried_by(&self, authorization: Option<&[u8]>) -> bool {
        let Some((scheme, given)) = authorization.and_then(|header| header.split_at_checked(7)) else { return false };
        scheme.eq_ignore_ascii_case(b"bearer ") && bool::from(self.0.as_slice().ct_eq(given.trim_ascii()))
    }
}

fn needless(bind: SocketAddr) -> anyhow::Result<()> {
    if bind.ip().to_canonical().is_loopback() {
        return Ok(());
    }
    Err(anyhow!(
        "--bind {bind} can be reached from elsewhere; allowed without a token: 127.0.0.1 and [::1]; say --token-file FILE or --token-env NAME"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_whole_token_counts() {
        let token = Token(b"0123456789abcdef".to_vec());
        assert!(token.is_carried_by(Some(b"Bearer 0123456789abcdef")));
        assert!(token.is_carried_by(Some(b"bearer  0123456789abcdef ")));
        for wrong in [
            None,
            Some(&b""[..]),
            Some(b"Bearer"),
            Some(b"Bearer "),
            Some(b"Bearer 0123456789abcde"),
            Some(b"Bearer 0123456789abcdef0"),
            Some(b"Bearer 0123456789abcdeg"),
            Some(b"Basic  0123456789abcdef"),
            Some(b"0123456789abcdef"),
        ] {
            assert!(!token.is_carried_by(wrong), "{wrong:?}");
        }
    }
}
