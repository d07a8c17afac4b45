/* A predator on an ESP32 or an Arduino: reads the robot's sensors and drives its two motors.
 *
 * Put the header beside this sketch:
 *     scripts/ros2 run coevo_manager export RUN --species predator --header predator.h
 * and fill in the four functions below for your board. What each reading is stands in the header.
 */
#include "predator.h"

static const unsigned long PERIOD_MS = 100;  /* that of evolution */

static predator_controller controller;
static float readings[37];
static unsigned long next_step_ms;

static float infrared_distance(int ray)
{
    (void)ray;
    return INFINITY;  /* m from the rim, or INFINITY: nothing seen */
}

static float camera_sector(int sector)
{
    (void)sector;
    return 0.0f;  /* share of the sector that the prey's lights fill */
}

static float ground_darkness(int sensor)
{
    return (float)analogRead(sensor) / 4095.0f;
}

static void drive_motor(int motor, float speed)
{
    analogWrite(motor, (int)(25.5f * fminf(fabsf(speed), 10.0f)));
    digitalWrite(motor + 2, speed < 0.0f ? HIGH : LOW);
}

void setup()
{
    predator_reset(&controller);
    next_step_ms = millis();
}

void loop()
{
    float wheels[2];
    int i;

    if ((long)(millis() - next_step_ms) < 0)
        return;
    next_step_ms += PERIOD_MS;
    for (i = 0; i < 24; i++)
        readings[i] = infrared_distance(i);
    for (i = 0; i < 8; i++)
        readings[24 + i] = camera_sector(i);
    for (i = 0; i < 4; i++)
        readings[32 + i] = ground_darkness(i);
    readings[36] = digitalRead(9) == HIGH ? 1.0f : 0.0f;  /* a bumper */
    predator_step(&controller, readings, wheels);
    drive_motor(0, wheels[0]);
    drive_motor(1, wheels[1]);
}
