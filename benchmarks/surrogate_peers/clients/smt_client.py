"""SMT: its Kriging, which standardises inputs and values itself."""

from fitting import serve
from smt.surrogate_models import KRG


def fitted(model, data):
    """The prediction of a trained model."""
    model.set_training_values(data.points, data.values)
    model.train()
    return model.predict_values, {}


MODELS = {
    "kriging": lambda data: fitted(KRG(n_start=1, print_global=False), data),
    "kriging-matern": lambda data: fitted(KRG(n_start=1, corr="matern52", print_global=False), data),
}

if __name__ == "__main__":
    serve(MODELS, ("smt", "numpy", "scipy"))
