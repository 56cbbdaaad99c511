"""The tables of `docs/scenario.md`, from the types of a scenario."""

from clew.manual.tables import Schema, name_of, table
from world.scenario.scenario import schema


def sections() -> str:
    """The file, each of its sections and each shape."""
    components = schema()["$defs"]
    fields = components["Scenario"]["properties"]
    named = {
        f"`[{name}]`": components[name_of(choice)]
        for name, field in fields.items()
        for choice in field.get("anyOf", [field])
        if "$ref" in choice
    }
    shapes = {
        f'`[[{key}]]`, `shape = "{name}"`': components[name_of({"$ref": reference})]
        for key in ("obstacle", "moving")
        for name, reference in fields[key]["items"]["discriminator"]["mapping"].items()
    }
    top = f"## The file\n\n{table(fields, components, defaults=True)}"
    return "\n".join([top, *(_section(*each, components) for each in (named | shapes).items())])


def _section(title: str, described: Schema, components: Schema) -> str:
    fields = {name: field for name, field in described["properties"].items() if name != "shape"}
    said = "\n".join(line.strip() for line in described["description"].splitlines())
    return f"## {title}\n\n{said}\n\n{table(fields, components, defaults=True)}"
