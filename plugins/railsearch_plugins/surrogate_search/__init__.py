"""Search on surrogates of objectives or responses: what strategies other than metric search share."""
