//! The access token of the API: from a file or an environment variable, never from the command line.

use std::net::SocketAddr;

use anyhow::anyhow;
use subtle::ConstantTimeEq;

use super::arguments::ServeArguments;

/// Shorter tokens can be guessed.
const SHORTEST: usize = 16;
const LONGEST: usize = 512;

/// Secret that requests carry; never printed.
pub struct Token(Vec<u8>);

impl Token {
    /// Reads the token that the flags name; on loopback it is optional.
    pub fn of(typed: &ServeArguments) -> anyhow::Result<Option<Self>> {
        let text = match (&typed.token_file, &typed.token_env) {
            (Some(path), _) => {
                let text = std::fs::read_to_string(path)
                    .map_err(|error| anyhow!("cannot read the token of {}: {error}", path.display()))?;
                text.lines().next().unwrap_or_default().trim().to_owned()
            }
            (None, Some(name)) => {
                std::env::var(name).map_err(|_| anyhow!("environment variable {name} is not set"))?.trim().to_owned()
            }
            (None, None) => return check_loopback(typed.bind).map(|()| None),
        };
        if !(SHORTEST..=LONGEST).contains(&text.len()) || !text.bytes().all(|byte| byte.is_ascii_graphic()) {
            let letters = text.chars().count();
            return Err(anyhow!(
                "invalid token of {letters} characters; allowed: {SHORTEST} to {LONGEST} printable ASCII characters without spaces"
            ));
        }
        Ok(Some(Self(text.into_bytes())))
    }

    /// Whether an Authorization header carries the token; compared in constant time.
    pub fn is_carried_by(&self, authorization: Option<&[u8]>) -> bool {
        let Some((scheme, given)) = authorization.and_then(|header| header.split_at_checked(7)) else { return false };
        scheme.eq_ignore_ascii_case(b"bearer ") && bool::from(self.0.as_slice().ct_eq(given.trim_ascii()))
    }
}

fn check_loopback(bind: SocketAddr) -> anyhow::Result<()> {
    if bind.ip().to_canonical().is_loopback() {
        return Ok(());
    }
    Err(anyhow!(
        "--bind {bind} is reachable from other machines; allowed without a token: 127.0.0.1 and [::1]; specify --token-file FILE or --token-env NAME"
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
