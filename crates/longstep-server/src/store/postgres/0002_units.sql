-- Units of campaigns: owning one is the right to run it. Their results are records.
ALTER TABLE longstep_log DROP CONSTRAINT longstep_log_kind_check,
    ADD CONSTRAINT longstep_log_kind_check CHECK (kind IN ('session', 'run', 'robot', 'audit', 'unit'));
