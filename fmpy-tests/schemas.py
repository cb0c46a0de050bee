"""What tests ask of a JSON Schema."""


def described(schema, place):
    """Every property below, with its description."""
    if isinstance(schema, list):
        for part in schema:
            yield from described(part, place)
    elif isinstance(schema, dict):
        fields = schema.get("properties", {})
        for name, field in fields.items():
            if not isinstance(field, dict) or "const" not in field:
                # What is one of several says it itself.
                yield f"{place}.{name}", field.get("description") or len(fields) == 1 and schema.get("description")
        for name, part in schema.items():
            yield from described(part, f"{place}.{name}")
