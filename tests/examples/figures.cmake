# What the programs print beside their errors holds for the case at hand, or is said to be missing; CMakeLists.txt includes this
# file.

# prints(<program> <what> "<arguments>" <regex>): the same as check(), without files or a picture of interest.
function(prints program title arguments regex)
  check(${program} "${title}" "${arguments} --no-plot" PRINTS "${regex}")
endfunction()

# Relativity turns the perihelion along the orbit, whatever its inclination and the ratio of the masses.
foreach(inclination IN ITEMS 0 30 63.4 91 150 180)
  prints(orbits "turns the perihelion at ${inclination} degrees" "--inclination ${inclination}deg --time \"3 year\""
    "perihelion advance: 42.9[78][0-9]* [^\n]*arcseconds a century .*; 1PN to first order: 42.98")
endforeach()
prints(orbits "turns the perihelion of equal masses" "--nu 0.25 --time \"3 year\"" "perihelion advance: 42.9[78][0-9]* [^\n]*arc")
# A J2 that turns it by k = 253.93 in the equator: k (2 - 5/2 sin²i) from the node, whose own turn is -k cos i.
set(j2 "--effects kinetic,attraction,j2 --j2 2e-3 --time \"10 year\"")
prints(orbits "turns by J2 in the equator" "${j2}" "perihelion advance: 254.01[0-9]* [^\n]*arc.*; J2 to first order: 254.016")
prints(orbits "turns by J2 at the critical inclination" "${j2} --inclination 63.4349488deg"
  "perihelion advance: -?0.0[0-9]* [^\n]*arc[^\n]*; J2 to first order: 0.000[^\n]*\n.*node: -113.[56][0-9]* [^\n]*arc[^\n]*: -113.[56]")
prints(orbits "turns by J2 over the poles" "${j2} --inclination 90deg"
  "perihelion advance: -127.0[0-9]* [^\n]*arc[^\n]*; J2 to first order: -127.00[0-9]*[^\n]*\n.*node: 0.0000+ [^\n]*arc[^\n]*: 0.0000+[^\n]*\n")
prints(orbits "turns by J2 against the rotation" "${j2} --inclination 150deg"
  "perihelion advance: 349.2[0-9]* [^\n]*arc[^\n]*: 349.27[0-9]*[^\n]*\n.*node: 2(19|20).[0-9]* [^\n]*arc[^\n]*: 219.98")
# The centre's spin, a million times the Sun's: Lense and Thirring.
prints(orbits "turns by the spin of the centre" "--effects kinetic,attraction,spin_orbit --gs \"1e36 m^5/s^3\" --time \"10 year\" --inclination 60deg"
  "perihelion advance: -119.37[0-9]* [^\n]*arc[^\n]*; spin to first order: -119.37[0-9]*[^\n]*\n.*node: 79.58")
# How far the formulas of first order are off: 0.0006, 0.026 and 0.014 there.
prints(orbits "says how far relativity to first order is off" "--preset hulse_taylor --effects kinetic,attraction,1pn --time \"0.05 year\""
  "perihelion advance: 4.22690[0-9]* [^\n]*; 1PN to first order: 4.22632[0-9]*, terms of second order: about 0.000[4-9]\n")
prints(orbits "says how far it is off for a long ellipse" "--preset hulse_taylor --effects kinetic,attraction,1pn --e 0.9 --dt 10 --time \"0.02 year\""
  "perihelion advance: 13.79[89][0-9]* [^\n]*: 13.7721[0-9]*, terms of second order: about 0.0[2-4]\n")
prints(orbits "says how far J2 to first order is off" "--preset gps --e 0.1 --inclination 90deg --dt 2min --time 20day"
  "perihelion advance: -12.61[45][0-9]* [^\n]*: -12.6000[0-9]*, terms of second order: about 0.0[1-2]\n")

# By steps of a tenth of a day -868493.85, by 0.02 days 0.0021 less.
prints(orbits "says how uncertain relativity of second order alone is" "--effects kinetic,attraction,2pn --time \"3 year\" --c \"500 km/s\" --dt \"0.1 day\""
  "perihelion advance: -86849[0-9.]+ ± ([1-9]|0[.]0*[1-9]) arc")

# By extrapolation in long double: 0.0118962, 0.06771795, -28.42085, and 2411.50256.
set(satellite "--preset gps --effects kinetic,attraction,j2")
prints(orbits "does not overrate how steps tell a long ellipse" "${satellite} --a 29737.098 --e 0.70888007 --inclination 1.10714786567335 --time 154714.9408 --dt 74.28494256"
  "perihelion advance: 0.011[89][0-9]* ± 0.000[1-9]")
prints(orbits "tells a long ellipse by fine steps" "${satellite} --a 24075.69364882582 --e 0.7176303312900054 --inclination \"63.43 deg\" --time 1968579.56497 --dt 9.85458046038"
  "perihelion advance: 0.06771[78][0-9]* ± [1-9]e-0[67]")
prints(orbits "does not overrate how steps tell an ellipse over the poles" "${satellite} --a 21808.418 --e 0.26195121 --inclination 1.5707963267949 --time 97017.36147 --dt 118.2775447"
  "perihelion advance: -28.420[89] ± 0.000[1-9]")
prints(orbits "does not overrate how steps tell a close binary" "--preset hulse_taylor --effects kinetic,attraction,1pn --a 148275.04 --e 0.5650122 --nu 0.14737019 --time 5733.867119 --dt 1.273578848"
  "perihelion advance: 2411.50[23] ± 0.00[1-9]")
# Likewise 35.69068113, 2.87938229 and 4.74675308e-06.
prints(charges "do not overrate how steps tell a bounce" "--preset dipole --energy \"110313 eV\" --r 7.3901 --pitch \"132.31 deg\" --time 57.005424 --dt 0.05169"
  "bounce period, s: 35.69068[0-9]* ± [1-9]e-0[56]")
prints(charges "do not overrate how steps tell a bounce of few gyrations" "--preset dipole --energy \"6.952e+06 eV\" --r 5.2988 --pitch \"68.174 deg\" --time 7.1788855 --dt 0.03003"
  "bounce period, s: 2.8794 ± 0.000[1-9]")
prints(charges "do not overrate how steps tell a bounce in a pull" "--preset bottle --effects kinetic,magnetic_bottle,electric --energy \"58496.2 eV\" --b0 \"-0.318396 T\" --pitch \"77.568 deg\" --length \"2.4708 m\" --time 2.5168785e-05 --dt 2.1888e-08 --ez \"2291 V/m\""
  "bounce period, s: 4.746753[0-9]*e-06 ± ")
# What was tried over the whole time reaches what it did in the trial, whatever the setting.
set(same "")
foreach(digit RANGE 1 9)
  list(APPEND same "${digit}.[0-9]e-1[12] expected, ${digit}.[0-9]e")
endforeach()
list(JOIN same "|" same)
prints(fast_charges "runs as many steps as were tried" "--preset solenoid --gamma 338.43 --b0 \"39 mT\" --effects kinetic,solenoid,electric --ez \"13.8 V/m\" --accuracy 1e-11 --cost-by gradients"
  "asked for, (${same})")
# Squares of such places are zero.
prints(fast_charges "turns a plane however near to the axis" "--preset solenoid --x 0 --y 1e-300" "turn of the plane[^\n]*: 0.2730035[0-9]*[^\n]*; Larmor[^\n]*: 0.27300352 ")
# By a method of second order 9.5767e-06, by others and a quarter of the step 9.5704e-06.
prints(fast_charges "counts the trajectory's error in a wiggle" "--preset undulator --method gauss --stages 1" "wiggle, m: 9.5[78][0-9]*e-06 ± ([6-9]e-09|[1-5]e-08); ")

# 0.0042743815 by the closed form; it was that half a step before the end, 0.0042966.
prints(vortices "tell the speed at the end of the run" "--preset wall --time 33" "speed along the wall at the end: 0.0042743[0-9]* ± [1-9]e-0[78]; [^\n]*: 0.0042743")
prints(orbits "tells steps that are too long of an orbit of any size" "--effects kinetic,attraction,j2 --a 0.387098e-14AU \
--gm 132712440018e-42km3/s2 --radius 696000e-14km --j2 0.01 --dt 8day --time 3year"
  "perihelion advance: not measured, a step goes through 49 degrees of the orbit; give a --dt 4 times smaller")
# What turns the periapsis of a circle nearly; relativity turns no node. The first is 4.2e4 off there.
prints(orbits "count a loss of energy in terms of second order" "--preset hulse_taylor --effects kinetic,attraction,spin_orbit,2.5pn --nu 0.25 --gm \"1 GMsun\" \
--a \"300 km\" --e 3e-4 --inclination 30deg --gs \"1e30 m^5/s^3\" --time \"2 s\" --dt \"1e-4 s\"" "perihelion advance: -38294[0-9]*[^\n]*, terms of second order: about [4-9]e.04\n")
prints(orbits "count nothing that does not turn a node" "--preset gps --effects kinetic,attraction,1pn --time 2day" "node: 0.0000000000 ± [^\n]*; 1PN to first order: 0.0000000000\n")
# By steps of half a minute -0.13082613; relativity of second order turns no node alone.
# 643449.713254 by an extrapolation method in long double; the cross term of 1PN and spin is half of the 16.8.
prints(orbits "count the cross term of relativity and spin" "--preset mercury --effects kinetic,attraction,1pn,spin_orbit --inclination \"180 deg\" \
--a 0.01 --e 0.01 --gs \"3e34 m^5/s^3\" --time \"0.1 year\" --dt \"2e-6 year\" --no-plot" "advance: 643449.713[0-9]* [^\n]*: 643432.957[0-9]*, terms of second order: about [12]e.01\n")
prints(orbits "count what relativity of second order makes of a node" "--preset gps --effects kinetic,attraction,j2,2pn --c 80 --j2 1e-5 --dt 2min --time 30day"
  "node: -0.130826127[0-9]* [^\n]*; J2 to first order: -0.1308532930, terms of second order: about ([3-9]e-05|0.000[1-3])\n")
# By half and a quarter of the step 1.040051 and 1.040013: run and companion are off by the same.
prints(vortices "do not trust a companion that is off alike" "--preset wall --dt 13.64 --time 545.6 --method midpoint --scheme strang" "at the end: 1.04005 ± 5e-05; [^\n]*\nspeed along the wall at the end: 0.08108[0-9]* ± [3-5]e-06")
prints(vortices "know how short steps round a speed" "--preset wall --dt 1e-11 --time 1e-10" "speed along the wall at the end: 0.000[67] ± 0.000[12]; ")
# By steps of half a second 1517.708956907; about the plane of the passages it was 1518.1709.
prints(orbits "turn along the orbit of each step" "--preset gps --a 6959.374 --e 0.016565695 --inclination 33.659deg --time 56454.72 --dt 14.4"
  "along the orbit: 1517.70[89][0-9]* ± 0.000[1-9]")
# 2e-5 of it were rounded away beside ± 1e-09.
prints(orbits "have the digits of their ±" "--preset hulse_taylor --time \"0.2 year\"" "perihelion advance: 4.226908[5-7] ± [1-3]e-07 ")
prints(orbits "have the digits of a small ±" "--preset hulse_taylor --effects kinetic,attraction,1pn --a \"1e4 AU\" --time \"2e6 year\" --dt \"1e3 year\""
  "perihelion advance: 0.0000000000000081[0-9] ± [1-9]e-17 ")

# 3.067 degrees are right; its steps go on by half a turn, and see the same of the swing over and over.
prints(black_hole "do not measure a swing by steps of half a turn" "--preset kerr --spin -0.68 --r 31.4 --l 5.9 --carter 0.1 --time 5000 --method midpoint --dt 500"
  "degrees off the equator: not measured, it turns by up to 1[0-9][0-9] degrees in a step; give a --dt [0-9]+ times smaller")
# 8.87839590e-09; theta is rounded by 1e-14 degrees.
prints(black_hole "know the rounding of a small tilt" "--preset kerr --carter 1e-18 --time 15 --dt 0.5"
  "degrees off the equator: 8[.]878[34][0-9]*e-09 ± [1-9]e-14\n")
# The periapsis, 9/1.5, is within the last step.
prints(black_hole "sees the closest approach within the last step" "--preset schwarzschild --p 9 --e 0.5 --time 170.5076314687729 --dt 2" "nearest r: (6[.]0000|5[.]9999)[0-9]* ± [1-9]e-05\n")

# What means nothing is not printed.
set(chaotic "not measured, a companion run of half the step parts from it before t = [0-9.]+; give a smaller --dt, or less --time where the motion is chaotic")
prints(charges "do not measure bounces in chaos" "--preset dipole --energy \"20 MeV\" --r 5" "bounce period, s: ${chaotic}\ndrift period[^\n]*: ${chaotic}\n")
prints(charges "do not measure without a companion" "--method tao" "gyrofrequency, rad/s: not measured, no companion run with --method tao tells its error; give another")
prints(lattice "does not measure a participation number in chaos" "--preset anderson --effects hopping,disorder,on_site --g 1 --time 1000"
  "participation number at the end: ${chaotic}\n")
prints(orbits "does not measure what the step hides" "--dt \"4 day\""
  "perihelion advance: not measured, a companion run leaves [^0-9]+ [0-9.e+]+ arcseconds a century open; give a smaller --dt")
# Nearly a circle, whose periapsis swings by J2/e: 8.33693 by an integration of fourth order with 2 s steps in long double.
prints(orbits "tells how far off the periapsis of nearly a circle is" "--preset gps --e 0.001"
  "perihelion advance: 8.33[0-9]* ± 0.0[0-2][0-9]* degrees a year from")
prints(orbits "takes a sign and a blank before a number" "--time ' +1 year'" "perihelion advance: 42.9")
prints(black_hole "says where the innermost orbit of a small hole is" "--preset schwarzschild --mass 1e-6 --dt 2.5e-7 --time 4e-3"
  "innermost stable circular orbit: r = 6e-06\n")
prints(orbits "does not measure a perihelion in less than two orbits" "--time \"100 days\"" "not measured, the run has no two whole orbits; give more --time")
prints(orbits "does not measure the perihelion of a circle" "--e 0 --time \"1 year\"" "too near to a circle")
prints(orbits "does not measure by a formula for something else" "--effects kinetic,attraction,rotating_frame --frame-rate 1 --time \"1 year\""
  "perihelion advance: not measured, that is for")
prints(orbits "does not call an open orbit closed" "--preset arenstorf --time 3 --dt 0.002" "closure: not measured, .*Jacobi's constant: ")
prints(orbits "finds no node near the equator" "--preset gps --time 2day --inclination 0.05deg" "node: not measured, it is too near to the equator to have one")
prints(orbits "does not compare a period derivative that is not of relativity alone" "--preset hulse_taylor --effects kinetic,attraction,2.5pn,j2 --j2 0.01 --radius \"700000 km\" --time \"0.02 year\""
  "period derivative: not measured, that is for")
prints(orbits "shows the digits of a small figure" "--preset gps --effects kinetic,attraction,spin_orbit --time 2day" "node: 0.0000008[0-9]+ ± [^\n]*; spin to first order: 0.0000008[0-9]+,")
prints(orbits "says how far the spin to first order is off for a near circle" "--e 0.003 --effects kinetic,attraction,spin_orbit --gs \"1e37 m5/s3\" --time 10 --dt \"0.05 day\""
  "advance: -1491.77[^\n]*: -1491.80[^\n]*second order: about 0.0[1-4]\n")
prints(black_hole "does not measure half an orbit" "--time 100" "not measured, the run has no whole orbit; give more --time")
prints(black_hole "does not measure a circle" "--e 0 --time 300" "not measured, r stays the same: a circle")
prints(black_hole "does not count turns over the poles" "--preset kerr --l 0 --carter 15 --time 500"
  "degrees off the equator: 90\n.*turns from apoapsis to apoapsis: not measured, the orbit goes over a pole")
prints(black_hole "counts turns past the poles" "--preset kerr --l 0.1 --carter 15" "degrees off the equator: 88.5[12][0-9]* ± 0.0[0-9]+\n.*to apoapsis: 1.56[0-9]* ± [1-9]e-0[56]; mean")
prints(charges "does not measure less than a turn" "--time 1e-7s" "gyrofrequency: not measured, the run has no whole turn; give more --time")
prints(charges "does not measure turns that a step hides" "--dt 2e-7s" "gyrofrequency: not measured, it turns by up to [0-9]+ degrees in a step; give a --dt")
prints(charges "does not take nearly a whole turn in a step for a small one backwards" "--dt 6e-7s" "gyrofrequency: not measured, it turns by up to 323 degrees in a step; give a --dt")
prints(charges "does not measure bounces where steps hide the gyration" "--preset bottle --dt 5e-8s --time 1e-4s" "bounce period: not measured, it turns by up to 2[0-9]+ degrees")
prints(charges "does not measure what does not turn" "--pitch 0" "gyrofrequency: not measured, nothing moves across the field")
prints(charges "says how well steps tell the turning point" "--preset bottle --b0 0.01T --time 3e-5 --dt 7e-7" "turning point, m: 0.5[0-9]+ ± 0.0[0-9]+; .*\nbounce period, s: 1.24[0-9]*e-05 ± ")
foreach(preset_and_value IN ITEMS "bottle --pitch 0" "bottle --energy 0" "dipole --pitch 0")
  check(charges "does not bounce in ${preset_and_value}" "--preset ${preset_and_value} --time 1e-6s --dt 1e-8s --no-plot" PRINTS "bounce period[^\n]*: not measured, nothing moves across the field" LACKS "nan")
endforeach()
prints(charges "does not compare with a formula for something else" "--preset bottle --effects kinetic,magnetic_bottle,electric --time 4e-5s"
  "bounce period, s: [0-9.e-]+; mean of [0-9]+ bounces?; no closed form, other effects")
prints(black_hole "does not wait for orbits of a body that is not bound" "--preset kerr --spin -0.9577 --r 7.772 --l -4.309 --carter 0.4168"
  "turns from apoapsis to apoapsis: not measured, the body is not bound, E >= 1; give another --r or --l")
prints(charges "measures nothing of a charge that is not held" "--preset dipole --energy \"30 MeV\" --r \"9 Rearth\" --pitch \"30 deg\" --time \"240 s\""
  "bounce period, s: not measured, the field does not hold the charge; .*drift period[^\n]*: not measured, the field does not hold the charge; give a smaller --r, or less --energy")
prints(charges "does not measure a drift that is uneven" "--preset dipole --effects kinetic,dipole_field,electric --energy \"1 MeV\" --pitch \"80 deg\" --ey \"5e-3 V/m\" --time 160 --dt 4e-3"
  "bounce period, s: 6.00[0-9]+; mean of 25 bounces; no closed form, .*drift period[^\n]*: not measured, other effects than the field make the drift uneven")
prints(charges "does not measure a drift that has hardly begun" "--preset dipole --time 1s" "drift period[^\n]*not measured, the drift is not yet large")
prints(charges "says how uncertain a short drift is" "--preset dipole --time 10s" "drift period[^\n]*: -7[4-9] ± [2-9]; adiabatic: -78")
prints(black_hole "does not measure r of orbits that pass a pole by less than a step"
  "--preset zoom_whirl --spin -0.9 --r 10.987174850656027 --l 0.0001324775949589623 --carter 23.66575623016902 --dt 0.5861833906757277 --time 616.5567159833214 --scheme blanes_moan6"
  "nearest r: not measured, the orbit passes the poles by less than a step.*farthest r: not measured, the orbit passes")
prints(black_hole "does not say a pole of an orbit that passes by" "--preset kerr --r 12.77 --l 6.89e-05 --carter 28.49 --dt 2.62 --time 212 --method gauss --stages 3" "degrees off the equator: 90 ± 5\n")
prints(charges "do not measure bounces that only touch the equator" "--preset dipole --effects kinetic,dipole_field,electric --ey 0 --ez \"1e-5 V/m\" --pitch 90deg --time 30"
  "bounce period, s: not measured, the charge turns near z = 0, where no bounce plainly ends")
prints(charges "do not bounce in the equator" "--preset dipole --pitch 90deg --time 20s" "bounce period, s: not measured, the charge stays")
prints(charges "do not call a short run one that stays in the equator" "--preset dipole --time 5e-7 --dt 1e-8" "bounce period, s: not measured, the run has no whole bounce. give more --time")
prints(charges "do not call a short run one that stays in the middle" "--preset bottle --time 1e-14 --dt 1e-14" "bounce period: not measured, the run has no whole bounce. give more --time")
prints(lattice "counts sites of next to no mass" "--preset anderson --mass 1e-200" "participation number at the end: 8.4204")
# cos² t, whose mean is a half: every second step is at the start of a beat.
prints(lattice "does not measure beats by a step a beat" "--preset dnls --sites 2 --effects hopping --method gauss --stages 8 --dt 3.14159 --time 62.8318" "on the site of the start, at least: not measured, it turns by up to 3[56][0-9] degrees in a step; give a --dt [0-9] times smaller")
prints(lattice "does not compare a start with the end of an exchange" "--preset dnls --sites 2 --time 0.2" "no closed form for that")
prints(vortices "do not measure turns that a step hides" "--preset disk --effects pairs,disk,rotation --rotation_rate 62.7 --dt 0.1" "turns at: not measured, it turns by up to 360 degrees in a step")
prints(vortices "do not measure a turn that has hardly begun" "--preset disk --time 0.3" "turns at: not measured")
prints(fast_charges "does not measure a radius far below the rest" "--gamma 1.000253562891185 --pitch 3.1415911317811447" "gyrofrequency: not measured, it moves nearly along the field")
prints(fast_charges "gyrates with the gamma of its rigidity" "--rigidity \"3e6 V\"" "gyrofrequency, rad/s: -2.953[0-9]*e.09; eB/.*: -2.953[0-9]*e.09 ")
prints(fast_charges "does not measure a focus of what starts at 0" "--preset quadrupole --x 0" "x at the end[^\n]*not measured.*\ny at the end")
prints(fast_charges "finds Larmor's turn behind the axis" "--preset solenoid --b0 \"1 T\"" "but for half turns: 5.46.*Larmor.*5.46.*difference [0-9.]+e-0[3-9]")
# Truly 1640.797, a half turn more.
prints(fast_charges "compares no turn whose half turns the formula has to count" "--preset solenoid --b0 \"3 T\" --length \"20 m\" --z \"-12 m\" --time \"8e-8 s\" --dt \"1e-11 s\""
  "but for half turns: 1637.655[0-9]*( ± [0-9.e-]+)?; no closed form, the slope's square times the turn is [0-9.]+, and is to be below 0.5")
prints(fast_charges "does not measure a wiggle by a step a period" "--preset undulator --dt 1.0007e-10" "wiggle: not measured, a step goes through 1 of a period; give a --dt 16 times smaller")
prints(fast_charges "does not measure a turn by a step as long as the solenoid" "--preset solenoid --dt 6e-9" "turn of the plane: not measured, a step goes through [0-9.]+ of the solenoid")
prints(fast_charges "says how well steps tell a wiggle" "--preset undulator --dt 1.1119e-11" "wiggle, m: 9.[0-9]+e-06 ± [1-9]e-0[78]; ")
prints(fast_charges "does not measure a wiggle with a drift" "--preset undulator --z 1" "wiggle: not measured, it starts where A is not 0")
prints(fast_charges "says what rounding leaves of the slippage" "--preset undulator --gamma 1e6 --dt 1.1119e-11" "slippage a period, m: 4.385[0-9]*e-14 ± 7e-18. ")
prints(fast_charges "does not measure a slippage that rounding hides" "--preset undulator --gamma 1e8" "slippage a period, m: not measured, it is lost in rounding, which is ± 7e-18. give a smaller --gamma")
foreach(arguments_and_reason IN ITEMS "undulator --gamma 3|the slope K/.* is 0.69, and is to be below 0.1" "undulator --y 1cm|k.y. is [0-9.]+, and"
    "quadrupole --time 1e-8|the slope is 0?.?[0-9.]+, and" "solenoid --x 0.2|the distance from the axis, [^\n]* is 6.7, and"
    "solenoid --x 0.02 --b0 1T|the slope eB[^\n]* is 0.55, and")
  string(REGEX MATCH "^([^|]*)\\|(.*)$" all "${arguments_and_reason}")
  set(arguments "${CMAKE_MATCH_1}")
  set(reason "${CMAKE_MATCH_2}")
  check(fast_charges "compares with no formula that does not hold, ${arguments}" "--preset ${arguments} --no-plot" LACKS "difference"
    PRINTS "(wiggle, m|x at the end, of that at the start|but for half turns): [0-9.e-]+( ± [0-9.e-]+)?. no closed form, ${reason}")
endforeach()
# The slope is small there, the speed not that of light.
prints(fast_charges "does not compare the slippage of what is slow" "--preset undulator --b0 0.01T --gamma 2"
  "wiggle, m: [^\n]*difference 3.[01]e-04.\nslippage[^\n]*no closed form, .1 . K")
prints(fast_charges "does not measure a gyration along the field" "--pitch 0" "gyrofrequency: not measured, it moves nearly along the field")
prints(fast_charges "does not measure where steps go through its turns" "--preset cosmic_ray --dt 0.005 --method gauss --stages 8"
  "nearest to the dipole: not measured, it turns by up to 1[0-9][0-9] degrees in a step")
# 0.9955 at least.
prints(fast_charges "does not measure a peak at the axis that a step hides" "--preset cosmic_ray --rigidity \"7.673e+09 V\" --y 0.1146 --z 3.569"
  "on the way: not measured, about the axis it turns by up to 77 degrees in a step; give a --dt 7 times smaller\nnearest to the dipole[^\n]*: 3.86")
# 4.6994466 and 0.9999974.
prints(fast_charges "does not measure how near a step comes that goes past the dipole" "--preset cosmic_ray --rigidity \"3e11 V\" --time 1.3 --dt 0.325"
  "nearest to the dipole[^\n]*: not measured, about the dipole it turns by up to 85 degrees in a step; give a --dt 7 times smaller")
prints(fast_charges "knows what the last step may hide" "--preset cosmic_ray --rigidity \"3e11 V\" --time 1.285 --dt 0.025"
  "way: (0.99[89]|1.000) ± 0.00[1-9]; forbidden: above 1\nnearest to the dipole[^\n]*: 4.70 ± 0.0[1-9]\n")
# 1.5214 and 1, in the first step.
prints(fast_charges "does not measure a turn that its first step hides" "--preset cosmic_ray --x 0.3 --y 1.5 --z 0 --dt 0.016 --time 0.32"
  "way: not measured[^\n]*\nnearest to the dipole[^\n]*: not measured, about the dipole it turns by up to 20 degrees in a step; give a --dt 3 times smaller")
by_shell(fast_charges "draws few rows of a swing as dots"
  "for sparse in '--preset undulator --samples 107' '--preset quadrupole --y 0 --time 3e-7s --dt 5e-11s --samples 60'; do $program $sparse --output dots && grep -q 'rows, too few per swing' dots/fast_charges.gp && grep -q '4:2 with points' dots/fast_charges.gp || exit 1; done; for preset in undulator quadrupole solenoid; do $program --preset $preset --output lines && grep -q '4:2 with lines' lines/fast_charges.gp || exit 1; done")
# Of 1982 loops, which rows 1.006 loops apart make eleven of.
by_shell(charges "draw rows a turn apart as dots"
  "$program --preset gyration --effects kinetic,uniform_field,electric --ey '100 V/m' --ex 0 --time '1.3e-3 s' --output dots && grep -q 'rows, too few per orbit for a line' dots/charges.gp && grep -q '2:3 with points' dots/charges.gp")
# Behind the trials it is at mirrors of 4 T, which come back.
by_shell(charges "tells no error of settings that have not seen what is hard"
  "$program --preset bottle --pitch '30 deg' --cost --no-plot >said && ! grep options.budget said && grep 'give a shorter --time' said && grep ',inf,' out/charges_cost.csv && awk -F, 'NR > 1 && $4 > 1 && $4 != \"inf\" && $4 != \"nan\" { exit 1 }' out/charges_cost.csv")
prints(charges "does not measure a turning point where the charge turns by two steps a gyration"
  "--preset bottle --effects kinetic,magnetic_bottle,electric --time 2036.5363293435341 --dt 0.20943951023931953 --charge -1 --mass 1 --energy 8.410086243631372e-08 --pitch 2.867661437300563 --b0 1.0 --length 0.004857351993464593 --ex 8.714603286921047e-08 --ey 2.3583475778363736e-07 --ez -6.846327904224275e-10 --method gauss --stages 8"
  "not measured, where it turns back it turns by up to 16[0-9] degrees in a step; give a --dt 3 times smaller")
# Truly 5.4535645e-06, by shorter steps.
prints(orbits "says how well steps tell what a loss of energy turns" "--preset hulse_taylor --effects kinetic,attraction,2.5pn --c 11000 --time 300000 --dt 20"
  "perihelion advance: 0.00000545[0-9]* ± [12]e-09 degrees a year")
# 1.8631581689e-10; a step of triple_jump8 is 5 roundings too long, and half of it as well.
prints(fast_charges "knows that steps are too long by their weights' rounding" "--preset undulator --gamma 8450.962349268442 --b0 \"1.6850926878281336 T\" --period 0.010843500300297092 --time 1.093240669721876e-09 --dt 2.2587617143013968e-12 --y 0 --scheme triple_jump8"
  "slippage a period, m: 1.8631[56][0-9]*e-10 ± [1-3]e-17; ")
prints(fast_charges "says what rounding leaves of the slippage far from the origin" "--preset undulator --gamma 1e5 --y 0 --z 300 --time 7e-10"
  "slippage a period, m: 4.3[0-9]*e-12 ± 1e-14")
prints(black_hole "does not measure an orbit of three steps" "--dt 10 --time 30" "nearest r: not measured, the run has too few steps; give a smaller --dt\n")
# By Carter's constant 48.034.
prints(black_hole "says how far it goes from the equator between steps" "--preset kerr --dt 3 --time 60" "degrees off the equator: 48.0[0-9]* ± 0.[0-9]+\n")
prints(black_hole "says how well steps tell the closest approach" "--preset zoom_whirl --scheme low_defect6_s15 --dt 3.09 --time 300" "nearest r: 1[.]8[0-9]* ± 0[.]0(0[1-9]|[12])\n")
# 1.100736 by steps of 10.
prints(black_hole "says how well steps tell the turns" "--preset zoom_whirl --spin 0.5 --r 30 --l 5.75 --dt 118 --time 2600" "to apoapsis: 1.10[01] ± 0.00[1-9]; mean of 1 orbit\n")
# 3.7728965.
prints(fast_charges "says how uncertain a turn by coarse steps is" "--preset solenoid --gamma 4.80993 --b0 \"0.0751 T\" --length 0.80594 --radius 0.01487 --time 5.8852274e-09 --dt 3.4354e-10"
  "but for half turns: 3.77[0-9]* ± 0.00[0-9]+; ")
# By steps of a hundredth of it 0.4528417; the steps and those half as long have 3e-6 between them.
prints(fast_charges "do not take a run and its companion that pass each other for a focus that is known" "--preset quadrupole --method midpoint --scheme triple_jump4 --gamma 191.874 --slope \"-0.00162852 T/m\" --x \"9.77916e-05 m\" --y \"8.74801 m\" --z \"0 m\" --time \"2.89549e-07 s\" --dt \"1.48e-8 s\""
  "x at the end[^\n]*: 0.453 ± 0.00[1-9]; ")
# Larmor's formula is exact here. The run and half its step miss the same of the ends by chance.
prints(fast_charges "says what steps of a low order miss of a solenoid's ends" "--preset solenoid --gamma 5.140537483511224 --b0 \"2.6170321498325952e-05 T\" --length 0.1698079697758438 --radius 0.0022634734856336563 --x 2.2634734856336564e-07 --y 0 --z -0.7823188076090635 --time 5.469223720145013e-09 --dt 1.196195817119696e-10 --scheme strang"
  "but for half turns: 0.00026 ± [1-9]e-05; Larmor[^\n]*: 0.00025852618 ")
# 0.0014946032; through one end, so that little of the field's length is passed.
prints(fast_charges "says what steps of a low order miss of one end of a solenoid" "--preset solenoid --b0 \"0.0031113 T\" --length 13.403m --radius 0.010664m --x 0.0081m --y 0 --z -6.9046578m --time 7.34835509e-10s --dt 6.399729e-11s --scheme strang"
  "but for half turns: 0.00149[0-9]+ ± [1-9]e-06; ")
prints(fast_charges "does not measure less than a turn" "--time 1e-12 --dt 1e-14" "gyrofrequency: not measured, the run has no whole turn; give more --time")
by_shell(fast_charges "paints Stoermer's region beside no other field"
  "$program --preset cosmic_ray --time 0.01 && grep forbidden out/fast_charges.gp && $program --preset cosmic_ray --time 0.01 --effects kinetic,dipole_field,uniform_field --b 5e-9 && ! grep forbidden out/fast_charges.gp")
prints(fast_charges "does not measure a region where rounding hides the momentum" "--preset cosmic_ray --rigidity \"1e-10 V\" --time \"1 s\"" "of the momentum a part of [0-9.e+]+ is lost in rounding; give a larger --rigidity")
prints(fast_charges "does not measure a region without a field" "--preset cosmic_ray --moment 0" "region: not measured, there is no field")
prints(fast_charges "says what rounding leaves of a small turn" "--preset solenoid --x 1mm --y 0.7mm --b0 \"1e-12 T\"" "but for half turns: 5[.]460[0-9]*e-12 ± 9e-16; Larmor")
prints(fast_charges "does not measure a turn from the axis" "--preset solenoid --x 0" "turn of the plane: not measured, it starts on the axis")
check(charges "has no figures of a run that failed" "--dt 1e-6s --time 1e-4s --no-plot" EXIT_CODE 1 COMPLAINT "step 1 failed"
  PRINTS "energy error, worst +FAILED at t = 0\n.*nothing else is measured" LACKS "nan|0.0e.00|gyro")
check(vortices "have no figures of a run that failed" "--dt 66.3 --no-plot" EXIT_CODE 1 COMPLAINT "step [0-9]+ failed"
  PRINTS "energy error, worst +FAILED at t = " LACKS "nan|0.0e.00")

# Over less than 20 years the planets' swings make hundreds of arcseconds a century; Neptune's second turn ends after 330.
refuses(solar_system "an audit that is too short" "--audit --time \"0.2 year\" --effects mercury,venus,1pn" "--audit: 0.2 years are too short: .* give a --time of 20 years or more")
refuses(solar_system "an audit too short for Neptune" "--audit --time \"300 year\"" "give a --time of 330 years or more")
check(solar_system "has no figures of a run that failed" "--preset outer --dt \"3000 days\" --time \"1000 year\" --no-plot" EXIT_CODE 1
  COMPLAINT "solar_system: at t = 16.[0-9]*: two bodies come so close .*, or as the step is too long. give a shorter --dt" PRINTS ": FAILED, errors mean nothing\n" LACKS "energy error")

# Values against their help.
refuses(orbits "a mass ratio above 1/4" "--nu 7" "--nu: '7' is not a number from 0 to 1/4")
refuses(orbits "light that stands" "--c 0" "--c: '0' is not a positive number")
refuses(orbits "an inclination of more than half a turn" "--inclination 200deg" "--inclination: '200deg' is not an angle from 0 to 180 deg")
refuses(orbits "an effect named twice" "--effects kinetic,attraction,kinetic" "--effects: kinetic is named twice")
refuses(black_hole "a spin of a hole without one" "--spin 0.5" "--spin means nothing to the preset schwarzschild with these effects; it goes with kerr, as in --effects kerr")
refuses(orbits "a value for an effect that is off" "--j2 1e-3" "--j2 means nothing to the preset mercury with these effects; it goes with j2, as in --effects kinetic,attraction,1pn,j2")
refuses(black_hole "a spin of what does not turn" "--spin 2" "--spin means nothing to the preset schwarzschild .*it goes with kerr")
refuses(lattice "a negative width" "--width -3" "--width: '-3' is not a number from 0 on")
refuses(lattice "half a seed" "--seed 1.5" "--seed: '1.5' is not a whole number from 0")
refuses(charges "a field without a start" "--b 0" "these values make no start")
foreach(program IN ITEMS orbits nls vortices driven ensemble_mpi)
  refuses(${program} "an option spelt wrongly" "--no-plott" "there is no option --no-plott; did you mean --no-plot")
endforeach()
refuses(nls "an option and its value" "--dtt 0.1" "there is no option --dtt; did you mean --dt")
refuses(nls "a checkpoint in a folder that is not there" "--checkpoint nowhere/x" "--checkpoint: the folder nowhere is not there; make it first")
refuses(orbits "a checkpoint that is a folder" "--checkpoint ." "--checkpoint: '.' is a folder")

# Weisberg and Taylor (2005): 4.226595 degrees a year, and -2.40242e-12 for the loss by gravitational waves.
prints(orbits "follows the pulsar of Hulse and Taylor" "--preset hulse_taylor --time \"0.2 year\""
  "not symplectic, by 2.5pn.*work of 2.5pn.*perihelion advance: 4.22[67][0-9]* [^\n]*degrees a year.*period derivative: -2.40194[0-9]*e-12( ± [1-9]e-[12][0-9])?; from [0-9]+ orbits; Peters: -2.40202")
# By steps of a minute -2.40194e-12, as by the times of the apoapsides.
foreach(dt IN ITEMS 2500 3500 5000)
  check(orbits "does not measure a period derivative by steps of ${dt} s" "--preset hulse_taylor --time 20day --method gauss --stages 8 --dt ${dt} --no-plot"
    LACKS "period derivative: -" PRINTS "period derivative: not measured, it turns by up to [0-9]+ degrees in a step; give a --dt [0-9]+ times smaller")
endforeach()
# 2.23482657e-05 by a quarter of the step, and by another method.
prints(lattice "does not overrate what steps tell of a flat top" "--preset dnls --sites 7 --j 0.26194853383900579 --g -0.021143314245600297 --mass 6.5189989927013423 --dt 0.11381160400734497 --time 55.540062755584344 --method gauss"
  "left on the site of the start, at least: 2[0-9.]*e-05 ± [1-9]e-0[56]")
# 0.99880609 and 0.80599781 by other steps and another method.
prints(fast_charges "say whether another peak may be the largest" "--preset cosmic_ray --rigidity \"5e9 V\" --x 1.3 --y 0.4 --z 0.6 --time 0.5"
  "way: 0.99[89][0-9]* ± 0.00[0-9]+;")
prints(fast_charges "see how skew a turn is" "--preset cosmic_ray --rigidity \"5e9 V\" --x 1.5 --y 0.2 --z 0.4 --time 0.5"
  "nearest to the dipole, Earth radius: 0.80[56][0-9]* ± 0.00[0-9]")
# -2.03124258e-13 in numbers of 128 bits.
prints(orbits "does not overrate how few steps tell a period derivative" "--preset hulse_taylor --e 0.02 --dt 915 --time 167436 --samples 2"
  "period derivative: -2.0312[0-9]*e-13 ± [1-9]e-1[78]")
prints(orbits "does not take the work of radiation for an error" "--preset hulse_taylor --time 60day --c \"20000 km/s\""
  "perihelion advance: [0-9.]+ ± [0-9.e-]+ degrees a year from [0-9]+ orbits; .*period derivative: -[0-9.e-]+( ± [0-9.e-]+)?; from")
prints(orbits "keeps books of a satellite in air" "--preset gps --a \"6700 km\" --e 0.001 --effects kinetic,attraction,drag --drag \"1e-13 1/m\" --air-height \"50 km\" --dt 1min --time 1day"
  "work of drag +-[0-9.]+e-06.*node: not measured, drag turns it, too")
# Of a spin alone cos i stays the same, so that the two angles add up; with J2 by an own integration.
prints(orbits "follows the periapsis along an orbit whose plane turns" "--effects kinetic,attraction,spin_orbit --a 1 --e 0.3 --inclination \"60 deg\" --gs \"2.600263943076179e+40 m^5/s^3\" --dt 0.005 --time 30.3"
  "along the orbit: -128591.7[0-9] ± 0.0[0-9] arcs")
prints(orbits "follows the periapsis of a low satellite along its orbit" "--preset gps --a \"7000 km\" --e 0.05 --inclination \"98 deg\" --time \"30 day\" --dt \"30 s\""
  "along the orbit: -1247.58[45][0-9]* ± [0-9.e-]+ degrees a year")
# By an own integration of ω itself -1.07160756.
prints(orbits "counts a short vector from a long one" "--preset hulse_taylor --effects kinetic,attraction,spin_orbit --gs 7.49e19 --e 0.003 --inclination 0.5 --dt 70 --time 572000"
  "perihelion advance: -1.071607[0-9]* ± [0-9.e-]+ ")
refuses(orbits "air of no height" "--preset gps --effects kinetic,attraction,drag --air-height 0" "--air-height: '0' is not a positive number")
# An accuracy of the figure itself: chosen, run, and right.
prints(orbits "finds Mercury's perihelion as accurately as is asked for" "--accuracy \"0.001 arcsec\" --cost-by gradients --time \"20 year\""
  "perihelion advance: 42.980[0-9]* [^\n]*arcseconds a century [^\n]*1PN to first order: 42.980[45][0-9]*, terms of second order: about .*perihelion advance: 0.001 arcsec asked for, [0-9.e-]+ reached")
foreach(angle IN ITEMS "5e-09 arcsec" "1e-12 deg")
  string(REGEX MATCH "[a-z]+$" unit "${angle}")
  check(orbits "says in ${unit} what is out of reach" "--accuracy \"${angle}\" --time \"20 year\" --no-plot" EXIT_CODE 1
    COMPLAINT "--accuracy ${angle} is out of reach: the best found is [0-9.]+e-[0-9]+ ${unit} .3 times the estimate. by .* errors below [0-9.]+e-[0-9]+ ${unit} .3 times the estimate. cannot be told from rounding"
    PRINTS "in radians: ${angle} of the perihelion advance are")
endforeach()
# A third of it is aimed at, so that the best of the table was often below what was asked for.
check(solar_system "says in its unit what is out of reach" "--audit --effects mercury,1pn --time \"20 year\" --accuracy \"1e-18 rad\" --cost-by gradients --no-plot"
  EXIT_CODE 1 COMPLAINT "--accuracy 1e-18 rad is out of reach: the best found is [0-9.]+e-(09|1[0-9]) rad .3 times the estimate. by splitting aba")
check(orbits "keeps the run where the accuracy was not measured" "--accuracy \"0.001 arcsec\" --cost-by gradients --time \"0.3 year\" --no-plot" EXIT_CODE 1
  COMPLAINT "perihelion advance: 0.001 arcsec asked for, and its error was not measured: the run is too short" FILE out/orbits.csv
  PRINTS "perihelion advance: not measured, the run has no two whole orbits")
check(orbits "counts what measuring leaves of the accuracy" "--accuracy \"0.0001 arcsec\" --cost-by gradients --time \"1 year\" --no-plot" EXIT_CODE 1
  COMPLAINT "0.0001 arcsec asked for, [0-9.]+e-[0-9]+ reached by the trajectory, but such steps over so short a time leave ± 0.0[0-9]+ by measuring"
  FILE out/orbits.csv PRINTS "perihelion advance: 42.9[0-9]+ ± 0.0[0-9]+ arc")
check(black_hole "says which option to shorten where the orbit ends" "--preset zoom_whirl --l 1 --time 500 --accuracy 1e-6 --cost-by gradients --no-plot" EXIT_CODE 1
  COMPLAINT "no step goes beyond t = 10[0-9], where the orbit ends, or is too hard. give a shorter --time")
refuses(orbits "an accuracy in squares of angles" "--accuracy 0.001arcsec2" "is no angle; give one in rad, deg or arcsec")
refuses(orbits "an accuracy in metres" "--accuracy \"3 km\"" "is no angle; give one in rad, deg or arcsec")
refuses(orbits "an accuracy of an angle where none is measured" "--preset gps --accuracy \"1 arcsec\"" "measures no angle; give a relative energy error")
