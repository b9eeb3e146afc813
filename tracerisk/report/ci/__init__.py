"""What jobs of CI take: alerts and figures in the formats of GitHub and GitLab."""
