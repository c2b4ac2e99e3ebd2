# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a store answers, in words: one line, no secret, and what to do about it."""

from __future__ import annotations

import re
from typing import Final

from tumtools.errors import FetchError

_NO_CREDENTIALS: Final = re.compile(
    r"169\.254\.169\.254|metadata\.google\.internal|Account must be specified"
)
"""Where machines of a cloud ask for their own credentials, when there are none in the environment."""
_VARIABLES: Final = {
    "s3": "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_REGION",
    "gs": "GOOGLE_SERVICE_ACCOUNT or GOOGLE_SERVICE_ACCOUNT_KEY",
    "az": "AZURE_STORAGE_ACCOUNT_NAME, and AZURE_STORAGE_ACCOUNT_KEY or AZURE_STORAGE_SAS_TOKEN",
}


def store_error(url: str, error: Exception, what: str) -> FetchError:
    """Make an error of ours.

    Args:
        url: What was asked for.
        error: What came of it.
        what: What that means, in a few words.

    """
    variables = _VARIABLES.get(url.partition("://")[0])
    if variables is not None and _NO_CREDENTIALS.search(str(error)):
        message = "there are no credentials in the environment"
        return FetchError(f"{what}: {message}", path=url, hint=f"set {variables}")
    return FetchError(f"{what}: {first_line(error)}", path=url)


def first_line(error: Exception) -> str:
    """Say what a store answers, without what may be a secret."""
    text = str(error)
    code = re.search(r"<Code>(\w+)</Code>", text)
    line = text.partition("\n")[0].partition("<")[0].rstrip(": ")
    line = re.sub(r"//[^/\s]*@", "//...@", line)  # a user and a password
    line = re.sub(r"\?[^\s:)]*", "?...", line)  # a signature
    return line[:300] + (f" ({code[1]})" if code else "")
