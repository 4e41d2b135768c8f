"""What tests share beside the examinations of turingfold.testing."""


def message_names(error: BaseException, *words: str) -> None:
    """Check that an error's text is one paragraph that holds all the words."""
    text = str(error)
    assert "\n" not in text
    for word in words:
        assert word in text, f"{word!r} is not in: {text}"
