"""What could not be exported as it is, in one list."""


class Problems:
    """Messages in order of appearance, each once, with the things that each is about."""

    def __init__(self):
        self._things = {}

    def add(self, thing, message):
        """`thing` is what the user sees in Blender ("material Glass"); `message` says what was found and what was done."""
        things = self._things.setdefault(message, [])
        if thing not in things:
            things.append(thing)

    def lines(self):
        result = []
        for message, things in self._things.items():
            shown = ", ".join(things[:5]) + (f" and {len(things) - 5} more" if len(things) > 5 else "")
            result.append(f"{shown}: {message}")
        return result

    def __len__(self):
        return len(self._things)
