function bool = sensorCheckHuman(~)
% Replaces ISETCam's test, which Octave refuses for sensors without a name. No camera here is an eye.
bool = false;
end
