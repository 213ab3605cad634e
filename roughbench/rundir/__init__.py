"""What lies beside a results file while it is computed: finished tasks, durable and checked."""
