import rclpy
from rclpy.logging import LoggingSeverity, get_logger, get_logging_severity_from_string, set_logger_level
from rclpy.logging import get_logger_effective_level

rclpy.init()
node = rclpy.create_node("n", namespace="/cell")
logger = node.get_logger()
print(logger.name, logger.get_child("arm").name, logger.get_child("arm").get_child("a").name)
print(logger.get_effective_level().name, logger.is_enabled_for(LoggingSeverity.DEBUG))
print(logger.debug("quiet"), logger.info("said"), logger.warn("w"), logger.warning("w"), logger.error("e"), logger.fatal("f"))
logger.set_level(LoggingSeverity.ERROR)
print(logger.info("quiet"), logger.error("said"), logger.get_child("arm").get_effective_level().name)
print([logger.info("once", once=True) for _ in range(2)])
logger.set_level(LoggingSeverity.INFO)


print([logger.info("x", skip_first=True) for _ in range(3)])
print([logger.info("x", throttle_duration_sec=10.0) for _ in range(3)])
print([logger.info("x", throttle_duration_sec=10.0, throttle_time_source_type=node.get_clock()) for _ in range(3)])
print(get_logging_severity_from_string("WARN").name, LoggingSeverity.WARN.value, get_logger_effective_level("other").name)
set_logger_level("other", LoggingSeverity.FATAL)
print(get_logger("other").get_effective_level().name)
for do in (
    lambda: get_logging_severity_from_string("LOUD"),
    lambda: logger.info("a %s", "b"),
    lambda: logger.info("x", nothing=True),
    lambda: logger.set_level("LOUD"),
    lambda: logger.set_level(LoggingSeverity.DEBUG),
    lambda: logger.get_child(""),
    lambda: get_logger(""),
    lambda: logger.log("x", LoggingSeverity.INFO),
    lambda: logger.log("x", "INFO"),
    lambda: logger.info(3),
    lambda: logger.info(),
):
    try:
        print(do())
    except Exception as error:
        print(type(error).__name__)
