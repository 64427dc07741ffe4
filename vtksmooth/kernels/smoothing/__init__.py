"""The one loop: schemes propose, constraints dispose."""
