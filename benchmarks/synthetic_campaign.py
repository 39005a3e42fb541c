"""A campaign of any size in a storage, without the time that its runs would take.

Every cell has its own study as a campaign makes it, with name, identity and note. One cell of each problem is truly run;
the trials of the others are copies of its trials, made by SQL.
"""

from collections.abc import Sequence

from sqlalchemy import Connection, MetaData, create_engine, func, insert, literal, select

from railsearch.campaign.cells import Campaign, CampaignProblem, CampaignStrategy
from railsearch.campaign.identity import cell_settings
from railsearch.campaign.problems import make_problems
from railsearch.campaign.tasks import cell_tasks
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings, given_designs
from railsearch.run import run_search
from railsearch.storage import Storage

STRATEGIES = ("random", "ga", "nsga2", "dycors", "lmsrs")
CHOICES = {"function": {"dimension": 10, "integers": 5}}
OF_TRIALS = ("trial_params", "trial_values", "trial_user_attributes", "trial_system_attributes")


def synthetic_campaign(problems: Sequence[str], cells: int, evaluations: int) -> Campaign:
    """A campaign of these problems, random search under five names, and about so many cells."""
    return Campaign(
        name="synthetic",
        budget=evaluations,
        repetitions=max(1, round(cells / len(problems) / len(STRATEGIES))),
        seed=1,
        problems=tuple(CampaignProblem(name, ProblemSettings(name, sections=CHOICES)) for name in problems),
        strategies=tuple(CampaignStrategy(label, "random") for label in STRATEGIES),
    )


def write_campaign(url: str, campaign: Campaign) -> None:
    """Write the campaign into an empty storage."""
    registry = load_plugins()
    problems = make_problems(registry, campaign)
    storage = Storage(url)
    run = dict.fromkeys(problems, "")
    engine, tables = create_engine(url), MetaData()
    tables.reflect(engine, only=["studies", "trials", *OF_TRIALS])
    for task in cell_tasks(registry, campaign, problems, campaign.cells(), "railsearch campaign synthetic.toml"):
        record = storage.run(task.description, task.space)
        problem, name = problems[task.cell.problem], task.description.name
        if not run[task.cell.problem]:
            run_search(registry, problem, cell_settings(campaign, task.cell), given_designs(problem), record)
            run[task.cell.problem] = name
        else:
            with engine.begin() as connection:
                copy_trials(connection, tables, run[task.cell.problem], name)
    engine.dispose()


def copy_trials(connection: Connection, tables: MetaData, source: str, target: str) -> None:
    """Give the study `target` copies of the trials of the study `source`."""
    studies, trials = tables.tables["studies"], tables.tables["trials"]
    here, there = (
        connection.execute(select(studies.c.study_id).where(studies.c.study_name == name)).scalar_one()
        for name in (source, target)
    )
    first = connection.execute(select(func.min(trials.c.trial_id)).where(trials.c.study_id == here)).scalar_one()
    offset = connection.execute(select(func.max(trials.c.trial_id))).scalar_one() + 1 - first
    replaced = {"trial_id": trials.c.trial_id + offset, "study_id": literal(there)}
    columns = [column.name for column in trials.c]
    copied = select(*(replaced.get(name, trials.c[name]) for name in columns)).where(trials.c.study_id == here)
    connection.execute(insert(trials).from_select(columns, copied))
    for table in (tables.tables[name] for name in OF_TRIALS):
        columns = [column.name for column in table.c if not column.primary_key]
        copied = (
            select(*(replaced["trial_id"] if name == "trial_id" else table.c[name] for name in columns))
            .select_from(table.join(trials, trials.c.trial_id == table.c.trial_id))
            .where(trials.c.study_id == here)
            .order_by(*table.primary_key)
        )
        connection.execute(insert(table).from_select(columns, copied))
