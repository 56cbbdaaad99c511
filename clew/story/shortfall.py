"""What a law that promises no clearance falls short of, in words."""

from world.scenario.sections import LawSection


def shortfall(law: LawSection, least_m: float) -> str:
    """The end of a sentence that has begun with the least clearance; empty: the law promises one."""
    if law.promises_clearance:
        return ""
    kept_m = law.epsilon_m - law.mu0_m
    short = f"{kept_m - least_m:.4f} m short of" if least_m < kept_m else "no less than"
    return (
        f"--law {law.law} promises none, and this is {short} the epsilon - mu0 = {kept_m:.4f} m "
        "that --law certified has to keep."
    )
