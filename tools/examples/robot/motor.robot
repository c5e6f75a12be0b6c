# SPDX-License-Identifier: MIT
*** Comments ***
robot motor.robot


*** Settings ***
Resource        encoders.resource
Test Setup      A Motor


*** Test Cases ***
The Shaft Is Where It Was Turned
    Turn Shaft    ${motor}    90
    Position Should Be    ${motor}    0.25
    ${reply}=    Request    ${motor}    40 42 02
    Should Be Equal    ${reply}    40 42 00 00 40 00 42

A Worn LED Is Reported Until It Is Made Good
    Set Fault    ${motor}    led_current_high
    ${reply}=    Request    ${motor}    40 42 02
    Should Be Equal    ${reply}    40 d0 1d 8d
    Clear Faults    ${motor}
    Request    ${motor}    40 50 10
    ${reply}=    Request    ${motor}    40 42 02
    Should Be Equal    ${reply}    40 42 00 00 00 00 02

An Hour Passes In A Moment
    ${turning}=    Make Encoder    f3668    shaft=6RPM    node=5
    Let Time Pass    ${turning}    3600
    Position Should Be    ${turning}    360


*** Keywords ***
A Motor
    ${encoder}=    Make Encoder    s3684-rs485
    Set Test Variable    ${motor}    ${encoder}
