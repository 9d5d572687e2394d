"""What a stand is worth before anything is measured on it: budgets, requirements, gains, Monte Carlo."""
