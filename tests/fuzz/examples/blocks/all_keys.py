class Pick:
    """Pick parts."""

    # | RiskAnnotation
    # | @Function {
    # |   name = Pick.place
    # |   callSequence = 1
    # |   next = Pick.place 9/10
    # |   next = done 1/10
    # | }
    # | @Component {
    # |   name = gripper
    # |   probability = 1e-4
    # |   quantity = 3
    # |   redundancy = required 2, common_cause 0.05, detected each_visit
    # | }
    # | @Component {
    # |   name = camera
    # |   probability := 2e-3  ! computed 1e-3; measured
    # |   quantity = 2
    # |   redundancy = true
    # | }
    # | @Component {
    # |   name = joint
    # |   probability = 2e-3
    # |   quantity = 2
    # |   redundancy = required 1, spare cold, switch 0.01, detected mission_start
    # | }
    def place(self):
        pass
