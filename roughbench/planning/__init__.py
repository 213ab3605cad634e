"""What is to be computed: experiments, models and realizations, cut into tasks that fit."""
