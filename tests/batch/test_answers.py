# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What stores answer is said in words that help."""

from __future__ import annotations

import pytest

from tumtools.batch.stores.answers import store_error


@pytest.mark.parametrize(
    ("url", "text", "variable"),
    [
        ("s3://lab/x", "Error performing PUT http://169.254.169.254/latest/api/token", "AWS_ACCESS_KEY_ID"),
        ("gs://lab/x", "Error performing GET http://metadata.google.internal/", "GOOGLE_SERVICE_ACCOUNT"),
        (
            "az://lab/x",
            "Generic MicrosoftAzure error: Account must be specified",
            "AZURE_STORAGE_ACCOUNT_NAME",
        ),
    ],
)
def test_missing_credentials_are_said_to_be_that(url: str, text: str, variable: str) -> None:
    error = store_error(url, RuntimeError(text), "the store cannot be used")
    assert error.message == "the store cannot be used: there are no credentials in the environment"
    assert variable in str(error.hint)
    assert "169.254" not in str(error)


def test_an_address_on_the_web_needs_no_credentials() -> None:
    error = store_error("http://169.254.169.254/x", RuntimeError("refused"), "the store cannot be used")
    assert error.hint is None
